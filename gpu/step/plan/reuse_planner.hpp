#pragma once
// What the next step does with lists of neighbours: from the choice, and from how far vertices have moved.

#include <array>
#include <cmath>

#include "gpu/base/box.hpp"
#include "gpu/base/extent.hpp"
#include "gpu/step/plan/plan.hpp"
#include "gpu/step/plan/reuse_choice.hpp"

namespace collided {

/// The lists at hand, and how fast their margin is used up.
class ListLife {
 public:
  bool are_valid() const { return valid_; }
  double margin() const { return margin_; }
  uint64_t frames() const { return frames_; }
  uint64_t length() const { return length_; }
  /// By a frame's median of the last few; what moves at once and then rests leaves it as it is.
  double per_frame() const { return steps_.median(); }

  void forget() { valid_ = false; }
  void make(double margin, uint64_t length) {
    valid_ = true;
    margin_ = margin, length_ = length;
    used_ = frames_ = 0;
  }
  /// `slack`: Displacement::slack of a frame that reuses them, or tried to.
  void observe(double slack) {
    ++frames_;
    const double used = margin_ - slack;
    last_step_ = std::max(0.0, used - used_);
    steps_.push(last_step_);
    used_ = used;
  }
  /// The next frame would probably leave the margin.
  bool are_used_up() const {
    constexpr double kUneven = 1.1;
    return used_ + kUneven * std::max(last_step_, per_frame()) > margin_;
  }

 private:
  bool valid_ = false;
  double margin_ = 0, used_ = 0, last_step_ = 0;
  uint64_t frames_ = 0, length_ = 0;
  LastTimes steps_;
};

/// Frames whose searches are alike share a choice; the lists serve all frames.
class ReusePlanner {
 public:
  explicit ReusePlanner(const SceneSpec& spec) {
    // Who names an engine wants to see it work.
    const bool is_off = spec.reuse == Reuse::kAuto && spec.engine != Engine::kAuto;
    choices_.fill(ReuseChoice(is_off ? Reuse::kOff : spec.reuse));
  }

  /// A step begins. `bounds`: of the last one.
  ListPlan begin(const LevelNeeds& needs, const Box<float>& bounds) {
    bounds_ = bounds;
    is_suited_ = !needs.is_any_hit() && !needs.finds_rest_pairs && !needs.kinds.triangle_triangle;
    choice_ = &choices_[2 * needs.is_ccd() + needs.has_filter()];
    if (!is_suited_ || !choice_->uses_lists()) return {};
    if (life_.are_valid() && life_.frames() > 0 && life_.are_used_up()) return make();
    return life_.are_valid() ? ListPlan{ListUse::kReused} : make();
  }
  /// A vertex left its margin.
  ListPlan replan(double slack) {
    life_.observe(slack);
    return make();
  }
  /// There was no room for lists.
  void refuse() {
    choice_->refuse();
    life_.forget();
  }
  /// The step is making lists: until it has ended there are none.
  void begin_making() { life_.forget(); }
  /// It has ended. `listed`: by steps that made lists.
  void end(const ListPlan& plan, double slack, uint64_t listed, double milliseconds, bool is_clean) {
    if (plan.use == ListUse::kMade) life_.make(plan.margin, listed);
    if (plan.use == ListUse::kReused) life_.observe(slack);
    if (is_suited_) choice_->observe(plan.use, milliseconds, is_clean);
  }
  ReuseFacts facts(const ListPlan& plan) const {
    ReuseFacts facts = choice_->facts();
    facts.use = plan.use;
    if (!is_suited_) facts.reason = ReuseReason::kUnsuited;
    if (plan.use != ListUse::kNone) facts.margin = life_.margin(), facts.frames = life_.frames();
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
    return {ListUse::kMade, rounded(std::min(choice_->run_length() * life_.per_frame(), widest()))};
  }
  /// Of use at all.
  double widest() const {
    const double side = largest_side(bounds_) / 16;
    return std::isfinite(side) ? side : 0;
  }
  /// To a power of the square root of 2: steps with other margins are recorded anew.
  static double rounded(double margin) {
    return margin > 0x1p-1000 ? std::exp2(std::ceil(2 * std::log2(margin)) / 2) : 0;
  }

  std::array<ReuseChoice, 4> choices_;
  ReuseChoice* choice_ = &choices_[0];  ///< of the step in work
  bool is_suited_ = false;
  ListLife life_;
  Box<float> bounds_{};
};

}  // namespace collided
