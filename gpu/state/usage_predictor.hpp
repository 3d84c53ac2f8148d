#pragma once
// What most scenes never need and a step can be told to do without; once it was needed it is kept at hand for a while.

namespace collided {

class UsagePredictor {
 public:
  /// The first step is ready for it.
  bool is_expected() const { return steps_left_ > 0; }
  /// Looks at a step that ran; whether it needed what it was told to do without, and has to run again.
  bool observe(bool needed) {
    const bool surprise = needed && !is_expected();
    steps_left_ = needed ? kSteps : steps_left_ > 0 ? steps_left_ - 1 : 0;
    return surprise;
  }

 private:
  static constexpr int kSteps = 64;
  int steps_left_ = 1;
};

}  // namespace collided
