#pragma once
// What the engine throws.

#include <stdexcept>
#include <string>
#include <utility>

namespace collided {

/// A field of the input has a value that cannot be used. `field` is its path within the input.
class InvalidInput : public std::invalid_argument {
 public:
  InvalidInput(std::string field, const std::string& what) : std::invalid_argument(what), field_(std::move(field)) {}
  const std::string& field() const { return field_; }

 private:
  std::string field_;
};

/// The scene would need more memory than its budget or the device has.
class ResourceExhausted : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// The device failed; the scene, and perhaps the device, cannot be used any more.
class DeviceError : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// FrameInput::cancelled returned true; the scene is as it was before the frame.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("the frame was cancelled") {}
};

}  // namespace collided
