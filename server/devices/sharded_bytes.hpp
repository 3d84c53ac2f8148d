#pragma once
// The bytes that a scene on several devices holds on each of them. No gRPC here.

#include <memory>
#include <utility>
#include <vector>

#include "gpu/sharded_quota.hpp"
#include "server/devices/device_bytes.hpp"

namespace collided::server {

/// What a shard holds counts in the scene's quota, and so in its client's, and in that of the shard's device; what the
/// scene holds as a whole, on the host, counts where its first shard is.
class ShardedBytes final : public ShardedQuota {
 public:
  /// `devices`: of each shard, one or more; shards on one device may share one.
  ShardedBytes(const std::shared_ptr<DeviceBytes>& scene, const std::vector<std::shared_ptr<DeviceBytes>>& devices) {
    for (const auto& device : devices) shards_.push_back(DeviceBytes::within(scene, device));
  }

  void take(uint64_t bytes) override { whole()->take(bytes); }
  void give_back(uint64_t bytes) noexcept override { whole()->give_back(bytes); }
  std::shared_ptr<MemoryQuota> of_shard(size_t k) const override { return shards_.at(k); }
  /// Of what the scene holds as a whole.
  const std::shared_ptr<DeviceBytes>& whole() const { return shards_.front(); }

 private:
  std::vector<std::shared_ptr<DeviceBytes>> shards_;
};

}  // namespace collided::server
