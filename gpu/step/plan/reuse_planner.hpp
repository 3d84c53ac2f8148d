#pragma once
// What the next step does with lists of neighbours: from the choice, and from how vertices left their tracks.

#include <array>
#include <cmath>

#include "gpu/base/box.hpp"
#include "gpu/search/neighbours.hpp"
#include "gpu/state/plan.hpp"
#include "gpu/step/plan/reuse_choice.hpp"

namespace collided {

/// The lists at hand, and how vertices leave their tracks.
class ListLife {
 public:
  const ListPlan& plan() const { return plan_; }
  /// Frames since they were made.
  double frames() const { return frames_; }
  uint64_t length() const { return length_; }

  void forget() { plan_ = {}; }
  /// For frames with these settings, or ones that reach no farther.
  void make(const ListPlan& plan, const FrameSettings& settings, uint64_t length, double moved) {
    plan_ = plan, settings_ = settings, length_ = length, moved_ = moved;
    frames_ = off_ = last_ = 0;
  }
  bool serve(const FrameSettings& settings) const {
    return plan_.use == ListUse::kMade && settings.reach_of_any_pair() <= settings_.reach_of_any_pair() &&
           settings.delta <= settings_.delta && frames_ < plan_.frames && off_ + kUneven * last_ <= plan_.margin;
  }
  /// A frame that reuses them, or tried to.
  void observe(const Displacement& found) {
    ++frames_;
    moved_ = found.moved;
    if (found.slack == Displacement::kNone) return;
    last_ = frames_ > 1 ? std::max(0.0, plan_.margin - found.slack - off_) : 0;
    off_ = plan_.margin - found.slack;
  }
  /// No frame reuses them any more.
  void end() {
    if (plan_.use == ListUse::kMade && frames_ > 0) {
      if (settings_.is_ccd())
        bend_.push(off_ / (frames_ * frames_));
      else
        speed_.push(off_ / frames_);
    }
    forget();
  }
  /// What vertices need for so many frames: they leave their tracks as the square of the time. Those that need much of
  /// the way that they go had better be looked at again. DCD knows of no way: tracks stand still.
  double margin_for(double frames, bool is_ccd) const {
    if (!is_ccd) return kUneven * speed_.median() * frames;
    return std::min(kUneven * bend_.median() * frames * frames, kMaxOfWay * moved_ * frames);
  }

 private:
  static constexpr double kUneven = 1.25, kMaxOfWay = 0.25;

  ListPlan plan_;
  FrameSettings settings_{};
  double frames_ = 0, off_ = 0,
         last_ = 0;   ///< how far the farthest was off, and by how much more than the frame before
  double moved_ = 0;  ///< how far the fastest moves in a frame
  uint64_t length_ = 0;
  LastTimes bend_, speed_;  ///< of vertices against the tracks of the last lists, in CCD and in DCD
};

/// Frames whose searches are alike share a choice; the lists serve all frames.
class ReusePlanner {
 public:
  explicit ReusePlanner(const SceneSpec& spec) : is_auto_(spec.reuse == Reuse::kAuto && spec.engine == Engine::kAuto) {
    // Who names an engine wants to see it work.
    const bool is_off = spec.worlds > 0 || (spec.reuse == Reuse::kAuto && !is_auto_);
    choices_.fill(ReuseChoice(is_off ? Reuse::kOff : spec.reuse));
  }
  /// Whether lists can save time at all in a scene that leaves it open.
  void suit(bool can_pay) { can_pay_ = can_pay; }

  /// A step begins. `bounds`: of the last one.
  ListPlan begin(const LevelNeeds& needs, const Box<float>& bounds) {
    settings_ = needs.settings;
    bounds_ = bounds;
    missed_ = false;
    is_suited_ = (can_pay_ || !is_auto_) && settings_.accuracy >= Accuracy::kGuarded && !needs.is_any_hit() &&
                 !needs.finds_rest_pairs && !needs.advances && !needs.kinds.triangle_triangle;
    choice_ = &choices_[2 * needs.is_ccd() + needs.filters_searches()];
    if (!is_suited_ || !choice_->uses_lists()) return {};
    return life_.serve(settings_) ? ListPlan{ListUse::kReused} : make();
  }
  /// Of a step by this plan.
  TrackTimes times(const ListPlan& plan) const {
    if (plan.use == ListUse::kMade) return {-1, 0, plan.margin};
    const double to = life_.frames() + 1;
    return {settings_.is_ccd() ? to - 1 : to, to, life_.plan().margin};
  }
  /// A vertex has left its track. Whatever made it do so: this is no frame to tell the next ones by.
  ListPlan miss(const Displacement& found) {
    life_.observe(found);
    life_.end();
    missed_ = true;
    return {};
  }
  /// Milliseconds that a thread may be at work on a step by this plan; 0: any number.
  double longest_step(const ListPlan& plan) const { return plan.use == ListUse::kMade ? choice_->longest_making() : 0; }
  /// It took longer.
  void give_up() {
    choice_->give_up();
    life_.forget();
  }
  /// There was no room for lists.
  void refuse() {
    choice_->refuse();
    life_.forget();
  }
  /// It has ended. `listed`: by steps that made lists.
  void end(const ListPlan& plan, const Displacement& found, uint64_t listed, double milliseconds, double work,
           bool is_clean) {
    if (plan.use == ListUse::kMade) life_.make(plan, settings_, listed, found.moved);
    if (plan.use == ListUse::kReused) life_.observe(found);
    if (is_suited_) choice_->observe(missed_ ? ListUse::kMade : plan.use, milliseconds, work, is_clean);
  }
  ReuseFacts facts(const ListPlan& plan) const {
    ReuseFacts facts = choice_->facts();
    facts.use = plan.use;
    if (!is_suited_) facts.reason = ReuseReason::kUnsuited;
    if (plan.use != ListUse::kNone)
      facts.margin = life_.plan().margin, facts.frames = static_cast<uint64_t>(life_.frames());
    return facts;
  }
  /// Tests in the lists.
  uint64_t length() const { return life_.length(); }

  /// Lists are of no use any more: the scene is made of something else.
  void forget() { life_.forget(); }
  /// Nobody has use for lists next.
  bool is_idle() const {
    return std::all_of(choices_.begin(), choices_.end(), [](const ReuseChoice& choice) { return choice.is_idle(); });
  }

 private:
  ListPlan make() {
    life_.end();
    const double frames = choice_->run_length();
    return {ListUse::kMade, rounded(std::max(life_.margin_for(frames, settings_.is_ccd()), narrowest())), frames};
  }
  /// What the check of tracks itself may be off, and more.
  double narrowest() const {
    const double largest = std::max(largest_component(bounds_.lo), largest_component(bounds_.hi));
    return std::isfinite(largest) ? 0x1p-40 * largest : 0;
  }
  /// To a power of the square root of 2: steps with other margins are recorded anew.
  static double rounded(double margin) {
    return margin > 0x1p-1000 && std::isfinite(margin) ? std::exp2(std::ceil(2 * std::log2(margin)) / 2) : 0;
  }

  std::array<ReuseChoice, 4> choices_;
  ReuseChoice* choice_ = &choices_[0];  ///< of the step in work
  FrameSettings settings_{};            ///< of that step
  bool is_auto_, can_pay_ = true;       ///< the scene leaves it open whether there are lists; they may save time
  bool is_suited_ = false, missed_ = false;
  ListLife life_;
  Box<float> bounds_{};
};

}  // namespace collided
