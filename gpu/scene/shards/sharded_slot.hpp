#pragma once
// Positions of one frame on their way to all shards of a scene.

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gpu/types.hpp"

namespace collided {

/// Each shard's device reads the bytes itself: from memory of the host through its own link, from memory of a device by
/// a copy between devices.
class ShardedSlot final : public FrameSlot {
 public:
  explicit ShardedSlot(std::vector<std::shared_ptr<FrameSlot>> slots) : slots_(std::move(slots)) {}
  ShardedSlot(const ShardedSlot&) = delete;
  ShardedSlot& operator=(const ShardedSlot&) = delete;
  /// The first one's memory goes last: others may still read it.
  ~ShardedSlot() override {
    while (!slots_.empty()) slots_.pop_back();
  }

  const std::shared_ptr<FrameSlot>& of_shard(size_t k) const { return slots_[k]; }

  std::span<std::byte> room(uint64_t bytes) override {
    if (bytes > room_.size())
      for (size_t k = 1; k < slots_.size(); ++k) slots_[k]->send({});  // waits for what it still reads
    return room_ = slots_[0]->room(bytes);
  }
  void send(const std::vector<MeshPositions>& updates) override {
    for (const auto& slot : slots_) slot->send(updates);
  }

 private:
  std::vector<std::shared_ptr<FrameSlot>> slots_;  ///< of each shard
  std::span<std::byte> room_;                      ///< of the first one
};

}  // namespace collided
