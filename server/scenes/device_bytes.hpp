#pragma once
// The bytes that scenes hold, on their backends and on the host for their triangles: counted for each scene, each
// client and the daemon. No gRPC here.

#include <atomic>
#include <memory>
#include <string>

#include "gpu/detector.hpp"

namespace collided::server {

/// One limit; a scene's is part of its client's, and that of the daemon's.
class DeviceBytes final : public MemoryQuota {
 public:
  /// `subject` and `limit_name` are for messages, such as "client:robot" and "max_device_bytes_per_client"; `most` is
  /// in bytes.
  DeviceBytes(std::string subject, std::string limit_name, uint64_t most, std::shared_ptr<DeviceBytes> whole = nullptr)
      : subject_(std::move(subject)), limit_name_(std::move(limit_name)), most_(most), whole_(std::move(whole)) {}
  /// The budget of one scene; 0: no limit but those of `whole`, which may be null.
  static std::shared_ptr<DeviceBytes> of_scene(uint64_t budget, std::shared_ptr<DeviceBytes> whole);

  /// Throws LimitExceeded.
  void take(uint64_t bytes) override;
  void give_back(uint64_t bytes) noexcept override;
  /// Throws LimitExceeded if so much could not be held even alone; `what` needs it.
  void check_could_hold(uint64_t bytes, const std::string& what) const;
  void set_most(uint64_t most) { most_ = most; }
  uint64_t held() const { return held_; }

 private:
  [[noreturn]] void refuse(const std::string& why) const;
  std::string holder() const;

  const std::string subject_, limit_name_;
  std::atomic<uint64_t> most_;
  std::atomic<uint64_t> held_ = 0;
  const std::shared_ptr<DeviceBytes> whole_;  // may be null
};

}  // namespace collided::server
