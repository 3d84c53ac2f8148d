#pragma once
// The bytes that a scene on several devices holds on each of them. No gRPC here.

#include <memory>
#include <utility>
#include <vector>

#include "gpu/sharded_quota.hpp"
#include "server/limits/device_bytes.hpp"

namespace collided::server {

/// What a part holds counts in the scene's quota, and so in its client's, and in that of the part's device; what the
/// scene holds as a whole, on the host, counts where its first part is.
class PartedBytes final : public ShardedQuota {
 public:
  /// `devices`: of each part, one or more; parts on one device may share one.
  PartedBytes(const std::shared_ptr<DeviceBytes>& scene, const std::vector<std::shared_ptr<DeviceBytes>>& devices) {
    for (const auto& device : devices) parts_.push_back(DeviceBytes::within(scene, device));
  }

  void take(uint64_t bytes) override { whole()->take(bytes); }
  void give_back(uint64_t bytes) noexcept override { whole()->give_back(bytes); }
  std::shared_ptr<MemoryQuota> of_shard(size_t k) const override { return parts_.at(k); }
  /// Of what the scene holds as a whole.
  const std::shared_ptr<DeviceBytes>& whole() const { return parts_.front(); }

 private:
  std::vector<std::shared_ptr<DeviceBytes>> parts_;
};

}  // namespace collided::server
