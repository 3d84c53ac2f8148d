#pragma once
// What a scene in shards holds, told device by device.

#include <cstddef>
#include <memory>

#include "gpu/types.hpp"

namespace collided {

/// SceneSpec::memory_quota of a scene in shards that counts each shard's memory apart. What is the scene's as a whole,
/// as its answers are, is taken of the quota itself. A scene in shards whose quota is none of these takes all of it
/// there.
class ShardedQuota : public MemoryQuota {
 public:
  /// Of shard k, which is on SceneSpec::part_devices[k]. Thread-safe, and never null.
  virtual std::shared_ptr<MemoryQuota> of_shard(size_t k) const = 0;
};

}  // namespace collided
