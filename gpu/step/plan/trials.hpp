#pragma once
// What all comparisons of measured times share: the times, and how often there may be one.

#include <algorithm>
#include <array>

namespace collided {

/// The last three of many numbers.
class LastTimes {
 public:
  void push(double milliseconds) {
    times_[next_] = milliseconds;
    next_ = (next_ + 1) % kKept;
    count_ = std::min(count_ + 1, kKept);
  }
  void clear() { count_ = next_ = 0; }
  bool is_full() const { return count_ == kKept; }
  /// The last where there are not as many yet; 0 without any.
  double median() const {
    if (count_ == 0) return 0;
    if (!is_full()) return times_[count_ - 1];
    const auto [a, b, c] = times_;
    return std::max(std::min(a, b), std::min(std::max(a, b), c));
  }

 private:
  static constexpr int kKept = 3;
  std::array<double, kKept> times_ = {};
  int count_ = 0, next_ = 0;
};

/// When the next comparison may begin: after a pause, which grows each time, and once all that comparisons cost is a
/// small share of all time. A scene that has become another one is compared soon, whatever comparisons have cost; if
/// that leads to nothing, the next change of that kind waits twice as long. Times in milliseconds.
class TrialBudget {
 public:
  static constexpr double kGain = 0.97;   ///< what the other way has to take of the time to be chosen
  static constexpr double kChange = 1.3;  ///< from here on a scene has become another one
  static constexpr int kFirstPause = 64;  ///< frames

  /// Frames before the first comparison; the share of all time that comparisons may take.
  TrialBudget(int first_wait, double share) : share_(share), wait_(first_wait) {}

  bool is_due() const { return is_over() && owed_ == 0; }
  /// The pause alone.
  bool is_over() const { return wait_ == 0; }

  /// A frame of a comparison took so much more than others.
  void owe(double milliseconds) { owed_ += std::max(0.0, milliseconds); }
  /// Any other frame.
  void earn(double milliseconds) { owed_ = std::max(0.0, owed_ - share_ * milliseconds); }
  void count_frame() {
    wait_ = std::max(0, wait_ - 1);
    hurry_ = std::max(0, hurry_ - 1);
  }

  /// A comparison has ended; the other way takes `ratio` times the time of the one that is kept. What loses clearly
  /// today loses tomorrow, unless the scene changes.
  void pause(double ratio = 1) {
    const int growth = ratio > kHopeless ? 8 : ratio > kClear ? 4 : 2;
    wait_ = pause_;
    pause_ = std::min(growth * pause_, kLongestPause);
  }
  /// The other way cannot be gone at all.
  void pause_longest() { wait_ = pause_ = kLongestPause; }
  void pause_for(int frames) { wait_ = frames; }
  void end_pause() { wait_ = 0; }
  /// The scene has become another one.
  void hurry() {
    if (hurry_ > 0) return;
    wait_ = std::min(wait_, kSoon);
    pause_ = kFirstPause;
    owed_ = 0;
    hurry_ = hurry_pause_;
    hurry_pause_ = std::min(2 * hurry_pause_, kLongestPause);
  }
  /// The comparison after a hurry paid.
  void forgive() { hurry_pause_ = kFirstPause; }

 private:
  static constexpr double kClear = 1.25, kHopeless = 2;     ///< ratios of times
  static constexpr int kSoon = 8, kLongestPause = 1 << 14;  ///< frames

  double share_;
  double owed_ = 0;  ///< what comparisons took, less the share that they may take
  int wait_, pause_ = kFirstPause;
  int hurry_ = 0, hurry_pause_ = kFirstPause;  ///< frames until a change counts again, this time and the next
};

}  // namespace collided
