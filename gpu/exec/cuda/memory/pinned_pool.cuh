#pragma once
// Pinned memory of the host for all scenes of the process.

#include <cuda_runtime.h>

#include <cstdint>

#include "gpu/exec/block_heap.hpp"
#include "gpu/exec/cuda/memory/cuda_call.cuh"

namespace collided {

/// Pinned memory, which every GPU of the process reads and writes. From any thread.
///
/// Small blocks come from chunks that stay with the process: cudaFreeHost waits until the device is idle, which on a GPU
/// that other scenes keep busy took 1.2 s (H200, 8 streams of graphs); each call holds up all other calls of the driver.
class PinnedPool {
 public:
  /// Lives as long as the process: the driver may be gone before static objects are destroyed.
  static PinnedPool& instance() {
    static auto* const pool = new PinnedPool;
    return *pool;
  }
  PinnedPool(const PinnedPool&) = delete;
  PinnedPool& operator=(const PinnedPool&) = delete;

  /// Aligned to 512 bytes. `what` begins the text of an error.
  std::byte* allocate(uint64_t bytes, const char* what) {
    if (bytes <= kMostFromHeap)
      if (std::byte* const block = heap_.allocate(bytes)) return block;
    void* memory = nullptr;
    check_cuda(cudaHostAlloc(&memory, bytes, cudaHostAllocPortable), what);
    return static_cast<std::byte*>(memory);
  }
  /// Work that has been enqueued must not use the memory any more.
  void deallocate(std::byte* memory) noexcept {
    if (!heap_.deallocate(memory)) cudaFreeHost(memory);
  }

 private:
  static constexpr uint64_t kMostFromHeap = uint64_t{1} << 20;
  static constexpr BlockHeap::Sizes kSizes{.chunk = uint64_t{8} << 20, .alignment = 512, .kept = 16};

  PinnedPool() = default;

  BlockHeap heap_{kSizes,
                  {[](uint64_t bytes) {
                     void* chunk = nullptr;
                     if (cudaHostAlloc(&chunk, bytes, cudaHostAllocPortable) == cudaSuccess)
                       return static_cast<std::byte*>(chunk);
                     cudaGetLastError();
                     return static_cast<std::byte*>(nullptr);
                   },
                   [](std::byte* chunk, uint64_t) { cudaFreeHost(chunk); }}};
};

}  // namespace collided
