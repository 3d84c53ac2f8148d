#pragma once
// Options of frames, checked once: a frame that changes none of them costs a comparison.

#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "gpu/scene/rules.hpp"
#include "gpu/state/settings.hpp"

namespace collided {

/// Holds what follows from options that the scene can have.
struct CheckedFrame {
  FrameSettings settings;
  std::vector<std::string> unused;  ///< options of the scene, as unused_options() names them
};

/// Returns all that check_frame() depends on. Each member of a frame is named, or this does not compile.
inline auto options_of(const FrameInput& frame) {
  const auto& [updates, slot, edit, mode, accuracy, delta, report, ignore_separating, advance, advance_mode, limits,
               trial, start_fraction, cancelled, progress, bytes_beside_contact, room, stream] = frame;
  return std::tuple(mode, accuracy, delta, report, ignore_separating, advance, advance_mode, limits, trial,
                    start_fraction, edit != nullptr, slot != nullptr, stream != nullptr, room.memory.empty(),
                    reinterpret_cast<uintptr_t>(room.memory.data()) % ContactRoom::kAlignment);
}

/// Checks the frames of one scene.
class FrameChecks {
 public:
  /// `spec`: of the scene, the same in each call until forget(). Throws what check_frame() throws.
  const CheckedFrame& check(const SceneSpec& spec, const FrameInput& frame) {
    const Options options = options_of(frame);
    if (last_ == options) return checked_;
    last_.reset();
    check_frame(spec, frame);
    checked_ = {settings_of(spec, frame), unused_options(spec, frame)};
    last_ = options;
    return checked_;
  }
  /// Must be called when the scene is edited.
  void forget() { last_.reset(); }

 private:
  using Options = decltype(options_of(FrameInput{}));

  std::optional<Options> last_;  ///< that passed
  CheckedFrame checked_{};
};

}  // namespace collided
