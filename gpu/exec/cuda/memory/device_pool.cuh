#pragma once
// Memory of a GPU for all scenes of the process.

#include <cuda_runtime.h>

#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>

#include "gpu/exec/block_heap.hpp"
#include "gpu/exec/cuda/memory/cuda_call.cuh"

namespace collided {

/// Memory of one device. From any thread, whose current device it must be.
///
/// cudaMalloc and cudaFree would synchronise the whole device, so memory comes from CUDA's pool of the device, which
/// keeps up to kPooledBytes of what is freed. Two facts about that pool, measured on an H200 with 800 scenes of 60
/// buffers each, which 12 threads create:
/// - It must be used on one stream. What is freed on one stream is searched for when another one allocates: with a stream
///   for each scene the second 800 scenes took 42.6 s, with one stream for all 0.2 s.
/// - A call takes 4 us under one lock of the driver. Blocks from a heap of our own take 0.5 us; small ones come from there.
class DevicePool {
 public:
  /// The device's pool, which lives as long as the process: the driver may be gone before static objects are destroyed.
  static DevicePool& of(int device) {
    static std::mutex mutex;
    static auto* const pools = new std::map<int, std::unique_ptr<DevicePool>>;
    const std::lock_guard lock(mutex);
    auto& pool = (*pools)[device];
    if (!pool) pool.reset(new DevicePool(device));
    return *pool;
  }
  DevicePool(const DevicePool&) = delete;
  DevicePool& operator=(const DevicePool&) = delete;

  /// For any stream from then on. `what` begins the text of an error.
  void* allocate(uint64_t bytes, const char* what) {
    if (bytes <= most_from_heap_)
      if (void* const block = heap_.allocate(bytes)) return block;
    void* memory = nullptr;
    check_cuda(take(&memory, bytes), what);
    return memory;
  }
  /// Work that has been enqueued must not use the memory any more.
  void deallocate(void* memory) noexcept {
    if (!heap_.deallocate(static_cast<std::byte*>(memory))) give_back(memory);
  }
  /// What the process holds without using it.
  uint64_t free_bytes() const {
    uint64_t reserved = 0, used = 0;
    if (pool_ == nullptr || cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrReservedMemCurrent, &reserved) != cudaSuccess ||
        cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrUsedMemCurrent, &used) != cudaSuccess)
      return heap_.free_bytes();
    return heap_.free_bytes() + (reserved > used ? reserved - used : 0);
  }

 private:
  static constexpr uint64_t kPooledBytes = uint64_t{1} << 30;
  static constexpr uint64_t kChunkBytes = uint64_t{32} << 20, kMostFromHeap = uint64_t{1} << 20, kAlignment = 512;

  explicit DevicePool(int device) {
    int is_supported = 0;
    uint64_t bytes = kPooledBytes;
    if (cudaDeviceGetAttribute(&is_supported, cudaDevAttrMemoryPoolsSupported, device) != cudaSuccess ||
        is_supported == 0 || cudaDeviceGetDefaultMemPool(&pool_, device) != cudaSuccess ||
        cudaMemPoolSetAttribute(pool_, cudaMemPoolAttrReleaseThreshold, &bytes) != cudaSuccess)
      pool_ = nullptr;
    check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
  }

  cudaError_t take(void** memory, uint64_t bytes) {
    if (pool_ == nullptr) return cudaMalloc(memory, bytes);
    const cudaError_t error = cudaMallocAsync(memory, bytes, stream_);
    return error == cudaSuccess ? cudaStreamSynchronize(stream_) : error;
  }
  void give_back(void* memory) noexcept {
    pool_ != nullptr ? cudaFreeAsync(memory, stream_) : cudaFree(memory);
  }

  cudaMemPool_t pool_ = nullptr;  ///< null: the device has none
  cudaStream_t stream_ = nullptr;
  /// compute-sanitizer sees where a buffer ends only if the buffer is an allocation of its own.
  const uint64_t most_from_heap_ = std::getenv("COLLIDED_NO_DEVICE_HEAP") != nullptr ? 0 : kMostFromHeap;
  BlockHeap heap_{{.chunk = kChunkBytes, .alignment = kAlignment},
                  {[this](uint64_t bytes) {
                     void* chunk = nullptr;
                     if (take(&chunk, bytes) == cudaSuccess) return static_cast<std::byte*>(chunk);
                     cudaGetLastError();
                     return static_cast<std::byte*>(nullptr);
                   },
                   [this](std::byte* chunk, uint64_t) { give_back(chunk); }}};
};

}  // namespace collided
