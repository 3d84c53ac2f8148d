#pragma once
// Whether frames go by lists of neighbours, and how many frames a list is meant to last. Candidates are the same, so
// that measured times may decide. Times come from outside, in milliseconds of any clock.
//
// A list serves a run of frames: the first makes it, which takes longer than a search alone, the others reuse it. Wide
// margins mean long runs, and long lists to go through in each frame. A comparison lasts until a run has been measured;
// if its frames take less on average than frames that search, lists stay, and half and twice as many frames are tried.
// What lost is tried again ever more rarely.

#include <algorithm>
#include <optional>
#include <utility>

#include "gpu/step/plan/trials.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Times of frames that make and reuse lists of one length.
class RunTimes {
 public:
  void add(ListUse use, double milliseconds, bool is_clean) {
    if (use == ListUse::kReused && run_ == 0) return;  // of a list of before
    if (use == ListUse::kMade) end_run();
    ++run_;
    if (is_clean) (use == ListUse::kMade ? made_ : reused_).push(milliseconds);
  }
  bool is_measured() const { return reused_.is_full() && ((last_run_ > 0 && made_.median() > 0) || run_ >= kLongRun); }
  /// Lists are made and not reused, again and again.
  bool is_hopeless() const { return short_runs_ >= kMaxShortRuns; }
  double reused() const { return reused_.is_full() ? reused_.median() : 0; }
  /// Of all frames of a run.
  double mean() const {
    const double frames = static_cast<double>(std::max(last_run_, run_));
    return (made_.median() + (frames - 1) * reused_.median()) / frames;
  }

 private:
  static constexpr int kLongRun = 64, kMaxShortRuns = 4;

  void end_run() {
    if (run_ > 0) short_runs_ = run_ == 1 ? short_runs_ + 1 : 0;
    last_run_ = std::exchange(run_, 0);
  }

  LastTimes made_, reused_;
  int run_ = 0, last_run_ = 0;  ///< frames of this run and of the one before
  int short_runs_ = 0;
};

/// How many frames lists are meant to last, by trying.
class RunLength {
 public:
  double frames() const { return trial_ ? *trial_ : frames_; }

  /// A frame of such runs takes so much on average; whether the next runs are of another length.
  bool observe(double mean) {
    const double before = frames();
    if (!trial_) {
      best_ = mean;
      if (runs_to_wait_-- <= 0) try_next();
    } else {
      const double tried = *std::exchange(trial_, std::nullopt);
      if (mean < kGain * best_)
        frames_ = tried, best_ = mean, losses_ = 1;  // the other way is where it came from
      else
        turn();
      try_next();
    }
    return frames() != before;
  }
  /// Lists of this length take too long to make.
  void shorten() {
    if (!std::exchange(trial_, std::nullopt)) frames_ = std::max(kShortest, frames_ / 2);
  }

 private:
  static constexpr double kGain = 0.98, kShortest = 2, kLongest = 64;
  static constexpr int kFirstPause = 4, kLongestPause = 1 << 10;

  void try_next() {
    for (; losses_ < 2; turn()) {
      const double next = frames_ * factor_;
      if (next < kShortest || next > kLongest) continue;
      trial_ = next;
      return;
    }
    losses_ = 0;
    runs_to_wait_ = pause_;
    pause_ = std::min(2 * pause_, kLongestPause);
  }
  void turn() {
    ++losses_;
    factor_ = 1 / factor_;
  }

  double frames_ = 8, factor_ = 2, best_ = 0;
  std::optional<double> trial_;
  int losses_ = 0, runs_to_wait_ = 0, pause_ = kFirstPause;
};

class ReuseChoice {
 public:
  explicit ReuseChoice(Reuse wanted = Reuse::kAuto) : wanted_(wanted) {
    if (wanted == Reuse::kAuto) return;
    reason_ = ReuseReason::kAsked;
    budget_.end_pause();
  }

  /// Of the next frame.
  bool uses_lists() const {
    if (wanted_ == Reuse::kOn) return budget_.is_over();
    return state_ == State::kTrying || (state_ == State::kUsing && searches_left_ == 0);
  }
  /// Frames that its list is meant to last.
  double run_length() const { return length_.frames(); }
  /// Milliseconds that the thread of a frame which makes lists may be at work on it; 0: any number. Frames that reuse a
  /// list save about half of a search at best, so that a list which takes longer than half the searches of its frames
  /// is of no use, and nobody is to wait for it.
  double longest_making() const {
    if (wanted_ == Reuse::kOn || !search_work_.is_full()) return 0;
    return std::max(kAlwaysAllowed, (1 + run_length() / 2) * search_work_.median());
  }
  /// Neither the next frame nor a comparison has use for lists.
  bool is_idle() const { return wanted_ != Reuse::kOn && state_ == State::kSearching; }
  ReuseFacts facts() const {
    return {.reason = is_comparing() ? ReuseReason::kTrial : reason_,
            .list_milliseconds = list_,
            .search_milliseconds = without_};
  }

  /// Looks at a frame. `work`: milliseconds that its thread was at work on it, which waits for a device that others
  /// use, too. `is_clean`: nothing was allocated for it.
  void observe(ListUse use, double milliseconds, double work, bool is_clean) {
    if (wanted_ == Reuse::kOff) return;
    if (use == ListUse::kNone && is_clean) search_work_.push(work);
    use == ListUse::kNone ? observe_search(milliseconds, is_clean) : observe_lists(use, milliseconds, is_clean);
  }
  /// Lists took too long to make.
  void give_up() {
    budget_.owe(longest_making());
    length_.shorten();
    lose(ReuseReason::kSlower);
  }
  /// There was no room for lists.
  void refuse() {
    if (wanted_ == Reuse::kOn) return budget_.pause_for(TrialBudget::kFirstPause);
    lose(ReuseReason::kNoRoom);
    budget_.pause_longest();
  }

 private:
  enum class State { kSearching, kTrying, kUsing };
  static constexpr double kShare = 0.0025;  ///< of all time may go to comparisons
  static constexpr int kFirstWait = 16;     ///< frames before the first comparison: engines are compared first
  static constexpr int kLongestTrial = 256, kSearches = 3;
  static constexpr double kAlwaysAllowed = 3;  ///< milliseconds: a thread that waits for a processor is not slow

  bool is_comparing() const { return state_ == State::kTrying || searches_left_ > 0; }

  void observe_search(double milliseconds, bool is_clean) {
    budget_.count_frame();
    if (wanted_ == Reuse::kOn) return;
    if (state_ == State::kUsing) return observe_check(milliseconds, is_clean);
    budget_.earn(milliseconds);
    if (is_clean) search_.push(milliseconds);
    if (!budget_.is_due() || !search_.is_full()) return;
    state_ = State::kTrying;
    times_ = {};
    trial_frames_ = 0;
  }
  /// Lists are in use; do they still pay?
  void observe_check(double milliseconds, bool is_clean) {
    budget_.owe(milliseconds - list_);
    if (is_clean) search_.push(milliseconds);
    if (--searches_left_ == 0 && search_.is_full()) decide();
  }

  void observe_lists(ListUse use, double milliseconds, bool is_clean) {
    times_.add(use, milliseconds, is_clean);
    if (state_ == State::kTrying) return observe_trial(milliseconds);
    if (use == ListUse::kMade && times_.is_measured()) tune();
    if (wanted_ == Reuse::kOn) return;
    budget_.earn(milliseconds);
    budget_.count_frame();
    if (times_.is_hopeless() || budget_.is_due()) check();
  }
  void observe_trial(double milliseconds) {
    budget_.owe(milliseconds - search_.median());
    const bool is_hopeless = times_.is_hopeless() || times_.reused() > search_.median();
    if (is_hopeless || ++trial_frames_ == kLongestTrial) return lose(ReuseReason::kSlower);
    if (times_.is_measured()) decide();
  }
  void check() {
    searches_left_ = kSearches;
    search_.clear();
  }

  void decide() {
    without_ = search_.median();
    if (times_.is_measured()) list_ = times_.mean();
    if (times_.is_hopeless() || !(list_ < TrialBudget::kGain * without_)) return lose(ReuseReason::kSlower);
    state_ = State::kUsing;
    reason_ = ReuseReason::kFaster;
    budget_.pause();
  }
  void lose(ReuseReason reason) {
    state_ = State::kSearching;
    searches_left_ = 0;
    reason_ = reason;
    budget_.pause();
  }

  /// After a run.
  void tune() {
    const double mean = times_.mean();
    if (list_ > 0 && mean > TrialBudget::kChange * list_) budget_.hurry();
    list_ = mean;
    if (length_.observe(mean)) times_ = {};
  }

  Reuse wanted_;
  State state_ = State::kSearching;
  ReuseReason reason_ = ReuseReason::kFirst;
  RunLength length_;
  RunTimes times_;                 ///< of lists of this length
  LastTimes search_;               ///< of frames without lists
  LastTimes search_work_;          ///< of their threads
  double list_ = 0, without_ = 0;  ///< as measured last
  TrialBudget budget_{kFirstWait, kShare};
  int trial_frames_ = 0;
  int searches_left_ = 0;  ///< of a comparison while lists are in use
};

}  // namespace collided
