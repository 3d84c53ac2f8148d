#pragma once
// Divides large chunks of memory among small blocks, so that a small block costs no call of a driver.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <utility>

namespace collided {

/// A best-fit heap over chunks from elsewhere. It never touches the memory that it divides, which may be a device's.
/// From any thread.
///
/// - Blocks of a chunk are adjacent and cover it; two free ones are never neighbours.
/// - A chunk without a used block goes back, but for the first few, which serve the next requests.
/// - deallocate() allocates nothing on the host, so that it cannot fail: a used block keeps the node that will index it
///   once it is free.
class BlockHeap {
 public:
  struct Chunks {
    std::function<std::byte*(uint64_t bytes)> take;  ///< null if there is no more memory
    std::function<void(std::byte* chunk, uint64_t bytes)> give_back;
  };

  struct Sizes {
    uint64_t chunk;      ///< bytes of a chunk
    uint64_t alignment;  ///< of chunks and blocks; a block has a multiple of it in bytes
    uint64_t kept = 1;   ///< empty chunks that do not go back
  };

  BlockHeap(const Sizes& sizes, Chunks chunks) : sizes_(sizes), chunks_(std::move(chunks)) {}
  BlockHeap(const BlockHeap&) = delete;
  BlockHeap& operator=(const BlockHeap&) = delete;

  /// A block of at least `bytes`, at most those of a chunk. Null if a chunk was needed and not to be had.
  std::byte* allocate(uint64_t bytes) {
    const uint64_t size = (std::max<uint64_t>(bytes, 1) + sizes_.alignment - 1) / sizes_.alignment * sizes_.alignment;
    const std::lock_guard lock(mutex_);
    auto fitting = free_.lower_bound({size, nullptr});
    if (fitting == free_.end()) {
      if (!add_chunk()) return nullptr;
      fitting = free_.lower_bound({size, nullptr});
    }
    const auto block = blocks_.find(fitting->second);
    const bool was_empty = block->second.bytes == sizes_.chunk;
    if (block->second.bytes > size) split(block, size);
    empty_chunks_ -= was_empty;
    block->second.place = free_.extract({block->second.bytes, block->first});
    free_bytes_ -= size;
    return block->first;
  }

  /// False if `memory` is no block of this heap.
  bool deallocate(std::byte* memory) noexcept {
    const std::lock_guard lock(mutex_);
    auto block = blocks_.find(memory);
    if (block == blocks_.end()) return false;
    free_bytes_ += block->second.bytes;
    index(block);
    const auto next = std::next(block);
    if (next != blocks_.end() && !next->second.begins_chunk && is_free(next)) merge(block, next);
    if (!block->second.begins_chunk && is_free(std::prev(block))) {
      const auto previous = std::prev(block);
      merge(previous, block);
      block = previous;
    }
    if (block->second.bytes == sizes_.chunk) retire(block);
    return true;
  }

  /// Of chunks that the heap holds.
  uint64_t free_bytes() const {
    const std::lock_guard lock(mutex_);
    return free_bytes_;
  }

 private:
  using Index = std::set<std::pair<uint64_t, std::byte*>>;  ///< sizes and addresses of free blocks
  struct Block {
    uint64_t bytes;
    bool begins_chunk;
    Index::node_type place;  ///< empty while the block is free
  };
  using Blocks = std::map<std::byte*, Block>;

  static bool is_free(Blocks::const_iterator block) { return block->second.place.empty(); }

  void index(Blocks::iterator block) noexcept {
    block->second.place.value() = {block->second.bytes, block->first};
    free_.insert(std::move(block->second.place));
    block->second.place = {};
  }
  /// Both are free, and adjacent in one chunk.
  void merge(Blocks::iterator block, Blocks::iterator next) noexcept {
    free_.erase({next->second.bytes, next->first});
    auto place = free_.extract({block->second.bytes, block->first});
    block->second.bytes += next->second.bytes;
    place.value().first = block->second.bytes;
    free_.insert(std::move(place));
    blocks_.erase(next);
  }
  /// Leaves `bytes` to a free block; the rest becomes a free block of its own.
  void split(Blocks::iterator block, uint64_t bytes) {
    const uint64_t rest = block->second.bytes - bytes;
    std::byte* const at = block->first + bytes;
    const auto added = blocks_.try_emplace(at, Block{rest, false, {}}).first;
    try {
      free_.insert({rest, at});
    } catch (...) {
      blocks_.erase(added);
      throw;
    }
    auto place = free_.extract({block->second.bytes, block->first});
    block->second.bytes = bytes;
    place.value().first = bytes;
    free_.insert(std::move(place));
  }
  bool add_chunk() {
    std::byte* const chunk = chunks_.take(sizes_.chunk);
    if (chunk == nullptr) return false;
    try {
      blocks_.try_emplace(chunk, Block{sizes_.chunk, true, {}});
      free_.insert({sizes_.chunk, chunk});
    } catch (...) {
      blocks_.erase(chunk);
      chunks_.give_back(chunk, sizes_.chunk);
      throw;
    }
    free_bytes_ += sizes_.chunk;
    ++empty_chunks_;
    return true;
  }
  /// A chunk without a used block.
  void retire(Blocks::iterator chunk) noexcept {
    if (empty_chunks_ < sizes_.kept) {
      ++empty_chunks_;
      return;
    }
    free_.erase({sizes_.chunk, chunk->first});
    free_bytes_ -= sizes_.chunk;
    chunks_.give_back(chunk->first, sizes_.chunk);
    blocks_.erase(chunk);
  }

  const Sizes sizes_;
  const Chunks chunks_;
  mutable std::mutex mutex_;
  Blocks blocks_;  ///< all of them, by address
  Index free_;
  uint64_t free_bytes_ = 0, empty_chunks_ = 0;
};

}  // namespace collided
