// BlockHeap against a model of its memory: blocks never overlap, chunks are shared and go back, shortages change nothing.

#include "gpu/exec/block_heap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

namespace collided::test {
namespace {

constexpr uint64_t kChunk = 1 << 16, kAlignment = 256, kKept = 2;

class BlockHeapTest : public ::testing::Test {
 protected:
  struct Used {
    std::byte* begin;
    uint64_t bytes;
  };

  /// Chunks are memory that nothing may touch; their addresses are all that counts.
  BlockHeap heap_{{.chunk = kChunk, .alignment = kAlignment, .kept = kKept},
                  {[this](uint64_t bytes) -> std::byte* {
                     if (chunks_.size() == most_chunks_) return nullptr;
                     next_ += bytes;  // chunks are adjacent, so that blocks of two could be merged
                     chunks_.push_back(next_ - bytes);
                     return chunks_.back();
                   },
                   [this](std::byte* chunk, uint64_t bytes) {
                     EXPECT_EQ(bytes, kChunk);
                     EXPECT_EQ(std::erase(chunks_, chunk), 1u);
                   }}};
  std::vector<std::byte*> chunks_;
  size_t most_chunks_ = 1000;
  std::byte* next_ = reinterpret_cast<std::byte*>(uint64_t{1} << 32);
};

uint64_t rounded(uint64_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

TEST_F(BlockHeapTest, BlocksNeverOverlapAndChunksGoBack) {
  std::mt19937_64 random(7);
  std::vector<Used> used;
  for (int round = 0; round < 20'000; ++round) {
    const bool grows = (round / 2000) % 2 == 0;  // tides
    if (used.empty() || random() % 8 < (grows ? 5 : 3)) {
      const uint64_t bytes = 1 + random() % (random() % 16 == 0 ? kChunk : 4000);
      std::byte* const begin = heap_.allocate(bytes);
      ASSERT_NE(begin, nullptr);
      EXPECT_EQ(reinterpret_cast<uintptr_t>(begin) % kAlignment, 0u);
      EXPECT_TRUE(std::ranges::any_of(chunks_, [&](std::byte* c) { return begin >= c && begin + bytes <= c + kChunk; }));
      for (const Used& other : used)
        ASSERT_TRUE(begin + rounded(bytes) <= other.begin || other.begin + other.bytes <= begin);
      used.push_back({begin, rounded(bytes)});
    } else {
      std::swap(used[random() % used.size()], used.back());
      ASSERT_TRUE(heap_.deallocate(used.back().begin));
      used.pop_back();
    }
    uint64_t bytes = 0;
    for (const Used& block : used) bytes += block.bytes;
    ASSERT_EQ(heap_.free_bytes(), chunks_.size() * kChunk - bytes);
  }
  while (!used.empty()) {
    EXPECT_TRUE(heap_.deallocate(used.back().begin));
    used.pop_back();
  }
  EXPECT_EQ(chunks_.size(), kKept) << "these empty chunks stay";
  EXPECT_EQ(heap_.free_bytes(), kKept * kChunk);
}

TEST_F(BlockHeapTest, TakesTheSmallestBlockThatFits) {
  std::byte* const first = heap_.allocate(1024);
  std::byte* const between = heap_.allocate(256);
  std::byte* const second = heap_.allocate(512);
  ASSERT_NE(heap_.allocate(256), nullptr);
  heap_.deallocate(first);
  heap_.deallocate(second);
  EXPECT_EQ(heap_.allocate(300), second);
  EXPECT_EQ(heap_.allocate(1000), first);
  EXPECT_EQ(heap_.deallocate(between), true);
  EXPECT_EQ(heap_.allocate(kChunk), chunks_.at(0) + kChunk) << "a whole chunk is the next one";
}

TEST_F(BlockHeapTest, AShortageChangesNothing) {
  most_chunks_ = 1;
  std::byte* const block = heap_.allocate(kChunk / 2 + 1);
  ASSERT_NE(block, nullptr);
  EXPECT_EQ(heap_.allocate(kChunk / 2), nullptr);
  EXPECT_EQ(heap_.allocate(kChunk / 4), block + kChunk / 2 + kAlignment);
  EXPECT_TRUE(heap_.deallocate(block));
  EXPECT_EQ(heap_.allocate(kChunk / 2), block);
}

TEST_F(BlockHeapTest, KnowsItsBlocks) {
  std::byte* const block = heap_.allocate(1000);
  EXPECT_FALSE(heap_.deallocate(block + kAlignment));
  EXPECT_FALSE(heap_.deallocate(nullptr));
  EXPECT_TRUE(heap_.deallocate(block));
}

}  // namespace
}  // namespace collided::test
