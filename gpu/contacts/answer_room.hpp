#pragma once
// Memory on the host for a scene's answers. Like the scene's buffers it grows to the need and stays, so that a frame
// like the last is never refused for what others have taken since, and allocates nothing.

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "gpu/types.hpp"

namespace collided {

/// Answers may outlive the scene. Thread-safe.
class AnswerRoom : public std::enable_shared_from_this<AnswerRoom> {
 public:
  using MakeBlock = std::function<std::shared_ptr<std::byte>(uint64_t bytes)>;

  /// `quota` may be null: then nothing is counted.
  AnswerRoom(std::shared_ptr<MemoryQuota> quota, MakeBlock make_block)
      : make_block_(std::move(make_block)), held_(std::move(quota)) {}

  /// Memory for one answer, until its last copy is gone; `beside`: bytes that its reader holds meanwhile. Throws what
  /// the quota throws, ResourceExhausted.
  std::shared_ptr<std::byte> take(uint64_t bytes, uint64_t beside) {
    const std::lock_guard lock(mutex_);
    Block block = free_block(bytes, beside);
    std::byte* const memory = block.memory.get();
    beside_ += beside;
    return {memory, [room = shared_from_this(), block = std::move(block), beside](std::byte*) mutable {
              room->give_back(std::move(block), beside);
            }};
  }
  /// The scene is gone: from now on only what answers use is held.
  void close() {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
    drop_free();
    held_.resize(made_ + beside_);
  }
  uint64_t bytes() const {
    const std::lock_guard lock(mutex_);
    return held_.bytes();
  }

 private:
  struct Block {
    std::shared_ptr<std::byte> memory;
    uint64_t bytes;
  };

  /// The smallest that is large enough; if there is none, a new one in place of those that are too small.
  Block free_block(uint64_t bytes, uint64_t beside) {
    const auto fits = [&](const Block& block) { return block.bytes >= bytes; };
    const auto smaller = [](const Block& a, const Block& b) { return a.bytes < b.bytes; };
    std::sort(free_.begin(), free_.end(), smaller);
    const auto found = std::find_if(free_.begin(), free_.end(), fits);
    if (found == free_.end()) return new_block(bytes + bytes / 4, beside);
    hold(made_ + beside_ + beside);
    Block block = std::move(*found);
    free_.erase(found);
    return block;
  }
  Block new_block(uint64_t bytes, uint64_t beside) {
    drop_free();
    hold(made_ + bytes + beside_ + beside);
    Block block{make_block_(bytes), bytes};
    free_.reserve(++blocks_);  // so that giving back never allocates
    made_ += bytes;
    return block;
  }
  void drop_free() {
    for (const Block& block : free_) made_ -= block.bytes, --blocks_;
    free_.clear();
  }
  /// Before the memory is there.
  void hold(uint64_t bytes) {
    if (bytes > held_.bytes()) held_.resize(bytes);
  }
  void give_back(Block block, uint64_t beside) {
    const std::lock_guard lock(mutex_);
    beside_ -= beside;
    free_.push_back(std::move(block));
    if (!is_closed_) return;
    drop_free();
    held_.resize(made_ + beside_);
  }

  const MakeBlock make_block_;
  mutable std::mutex mutex_;
  MemoryHold held_;
  std::vector<Block> free_;
  size_t blocks_ = 0;
  uint64_t made_ = 0, beside_ = 0;  ///< bytes of all blocks; bytes that readers hold
  bool is_closed_ = false;
};

}  // namespace collided
