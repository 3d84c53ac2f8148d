// Freed memory goes back to the system.
#include "server/ops/freed_memory.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <cstring>
#include <memory>
#include <thread>
#include <vector>

#include "tests/support/sanitized.hpp"

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

class FreedMemoryTest : public testing::Test {
 protected:
  void SetUp() override {
    if (test::kIsSanitized) GTEST_SKIP() << "the sanitizer's allocator keeps freed memory, to find who uses it";
  }
};

TEST_F(FreedMemoryTest, GoesBackOnceItIsMuch) {
  FreedMemory freed;
  Heap heap(64 << 20);
  heap.free_large();
  const double held = process_private_bytes();
  freed.give_back();
  EXPECT_LT(process_private_bytes(), held - (48 << 20));
}

/// Resident memory that is not the allocator's.
class Mapped {
 public:
  explicit Mapped(size_t bytes)
      : bytes_(bytes), memory_(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)) {
    std::memset(memory_, 1, bytes);
  }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  ~Mapped() { munmap(memory_, bytes_); }

 private:
  size_t bytes_;
  void* memory_;
};

// What was resident and not the allocator's for a while does not stand for what the allocator keeps after it.
TEST_F(FreedMemoryTest, AlsoWhereAsMuchThatWasNeverTheAllocatorsIsGone) {
  FreedMemory freed;
  const double before = process_private_bytes();
  auto mapped = std::make_unique<Mapped>(64 << 20);
  freed.give_back();
  Heap heap(48 << 20);
  freed.give_back();
  mapped = nullptr;
  heap.free_large();
  freed.give_back();
  EXPECT_LT(process_private_bytes(), before + (16 << 20));
}

// What is freed during a return is returned by the next. The allocator goes through its arenas one
// after the other: this thread's is done while those of the others, which take longer, are not.
TEST_F(FreedMemoryTest, AlsoWhatAnotherThreadFreesMeanwhile) {
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
