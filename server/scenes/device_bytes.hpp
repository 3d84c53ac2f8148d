#pragma once
// The bytes that scenes hold on their backends, counted for each client and for the daemon. No gRPC here.

#include <atomic>
#include <memory>
#include <string>

#include "gpu/detector.hpp"

namespace collided::server {

/// One limit; a client's is part of the daemon's.
class DeviceBytes final : public MemoryQuota {
 public:
  /// `subject` and `limit_name` are for messages, such as "client:robot" and "max_device_bytes_per_client".
  DeviceBytes(std::string subject, std::string limit_name, uint64_t most, std::shared_ptr<DeviceBytes> whole = nullptr)
      : subject_(std::move(subject)), limit_name_(std::move(limit_name)), most_(most), whole_(std::move(whole)) {}

  /// Throws LimitExceeded.
  void take(uint64_t bytes) override;
  void give_back(uint64_t bytes) noexcept override;
  void set_most(uint64_t most) { most_ = most; }
  uint64_t held() const { return held_; }

 private:
  const std::string subject_, limit_name_;
  std::atomic<uint64_t> most_;
  std::atomic<uint64_t> held_ = 0;
  const std::shared_ptr<DeviceBytes> whole_;  // may be null
};

}  // namespace collided::server
