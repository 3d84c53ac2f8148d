#pragma once
// The bytes that scenes hold, on their backends and, for their triangles, on the host: counted per scene, per client,
// per device and for the daemon. No gRPC here.

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <string>

#include "gpu/detector.hpp"

namespace collided::server {

/// One quota. A scene's lies within its client's, which lies within the daemon's, and within its device's.
class DeviceBytes final : public MemoryQuota {
 public:
  /// `subject` and `limit_name` are for messages, such as "client:robot" and "max_device_bytes_per_client"; `max` is in
  /// bytes; `parent` is the enclosing quota, or null.
  DeviceBytes(std::string subject, std::string limit_name, uint64_t max, std::shared_ptr<DeviceBytes> parent = nullptr)
      : subject_(std::move(subject)), limit_name_(std::move(limit_name)), max_(max), parents_{std::move(parent)} {}
  /// The budget of one scene; 0: no limit but that of `parent`, which may be null.
  static std::shared_ptr<DeviceBytes> of_scene(uint64_t budget, std::shared_ptr<DeviceBytes> parent);
  /// Without a limit but those of a client, which may be null, and of a device.
  static std::shared_ptr<DeviceBytes> within(std::shared_ptr<DeviceBytes> client, std::shared_ptr<DeviceBytes> device);

  /// Throws LimitExceeded.
  void take(uint64_t bytes) override;
  void give_back(uint64_t bytes) noexcept override;
  /// Throws LimitExceeded if `bytes`, which `what` needs, would not fit even if nothing else were held.
  void check_could_hold(uint64_t bytes, const std::string& what) const;
  void set_max(uint64_t max) { max_ = max; }
  uint64_t held() const { return held_; }
  /// Up to the limit.
  uint64_t left() const {
    const uint64_t held = held_, max = max_;
    return max - std::min(max, held);
  }

 private:
  void take_of_parents(uint64_t bytes);
  [[noreturn]] void refuse(const std::string& why) const;
  std::string holder() const;

  const std::string subject_, limit_name_;
  std::atomic<uint64_t> max_;
  std::atomic<uint64_t> held_ = 0;
  std::array<std::shared_ptr<DeviceBytes>, 2> parents_;  // may be null; fixed once it is shared
};

}  // namespace collided::server
