#pragma once
// Counts what a scene on several devices holds, device by device.

#include <cstddef>
#include <memory>

#include "gpu/types.hpp"

namespace collided {

/// A SceneSpec::memory_quota that counts the memory of each shard separately. What belongs to the scene as a whole,
/// such as its answers, is taken from this quota itself. A sharded scene with any other quota takes all of its memory
/// there.
class ShardedQuota : public MemoryQuota {
 public:
  /// Returns the quota of shard k, which is on SceneSpec::part_devices[k]. Thread-safe, and never null.
  virtual std::shared_ptr<MemoryQuota> of_shard(size_t k) const = 0;
};

}  // namespace collided
