// Freed memory goes back to the system.
#include "server/ops/freed_memory.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <thread>
#include <vector>

namespace collided::server {
namespace {

constexpr size_t kBlock = 64 << 10;

/// Memory of the heap: blocks, each before a small one that stays, so that the allocator alone returns none of it.
class Heap {
 public:
  Heap() = default;
  explicit Heap(size_t bytes) {
    for (size_t i = 0; i < bytes / kBlock; ++i) {
      large_.push_back(std::make_unique_for_overwrite<char[]>(kBlock));
      std::memset(large_.back().get(), 1, kBlock);
      small_.push_back(std::make_unique<int>(1));
    }
  }
  void free_large() { large_.clear(); }

 private:
  std::vector<std::unique_ptr<char[]>> large_;
  std::vector<std::unique_ptr<int>> small_;
};

TEST(FreedMemory, GoesBackOnceItIsMuch) {
  FreedMemory freed;
  Heap heap(64 << 20);
  heap.free_large();
  const double held = process_private_bytes();
  freed.give_back();
  EXPECT_LT(process_private_bytes(), held - (48 << 20));
}

// What is freed during a return is no part of what can never be returned. The allocator goes through its arenas one
// after the other: this thread's is done while those of the others, which take longer, are not.
TEST(FreedMemory, AlsoWhatAnotherThreadFreesMeanwhile) {
  std::vector<Heap> others(4);
  for (int round = 0; round < 20; ++round) {
    FreedMemory freed;
    const double before = process_private_bytes();
    Heap own(32 << 20), late(32 << 20);
    std::vector<std::jthread> threads;
    for (Heap& other : others)
      threads.emplace_back([&other] {
        other = Heap(64 << 20);
        other.free_large();
      });
    threads.clear();
    own.free_large();
    {
      const std::jthread another([&late] { late.free_large(); });
      freed.give_back();
    }
    freed.give_back();
    EXPECT_LT(process_private_bytes(), before + (16 << 20)) << "round " << round;
  }
}

}  // namespace
}  // namespace collided::server
