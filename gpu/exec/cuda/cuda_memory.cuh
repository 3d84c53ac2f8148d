#pragma once
// Errors, memory, streams and events of CUDA, each owned by an object.

#include <cuda_runtime.h>

#include <memory>
#include <string>
#include <utility>

#include "gpu/exec/memory_ledger.hpp"

namespace collided {

inline void check_cuda(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();
  const std::string text = std::string(what) + ": " + cudaGetErrorString(error);
  if (error == cudaErrorMemoryAllocation) throw ResourceExhausted(text);
  throw DeviceError(text);
}

/// For the calling thread; returns the device.
inline int use_device(int device) {
  check_cuda(cudaSetDevice(device), "cudaSetDevice");
  return device;
}

// Memory of the device comes from the device's pool: cudaMalloc and cudaFree let everything on the device wait, also
// the frames of other scenes. What scenes gave back stays with the process, up to kPooledBytes, for the next ones.

constexpr uint64_t kPooledBytes = uint64_t{1} << 30;

/// Sets it up; false: the device has none.
inline bool has_memory_pool(int device) {
  int is_supported = 0;
  if (cudaDeviceGetAttribute(&is_supported, cudaDevAttrMemoryPoolsSupported, device) != cudaSuccess ||
      is_supported == 0)
    return false;
  cudaMemPool_t pool = nullptr;
  uint64_t bytes = kPooledBytes;
  return cudaDeviceGetDefaultMemPool(&pool, device) == cudaSuccess &&
         cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &bytes) == cudaSuccess;
}

/// Memory of the device, booked in a scene's ledger. From any thread.
class DeviceMemory {
 public:
  DeviceMemory(int device, std::shared_ptr<MemoryLedger> ledger)
      : device_(device), ledger_(std::move(ledger)), is_pooled_(has_memory_pool(device)) {}

  /// For any stream from then on. `device` is the calling thread's.
  void* allocate(const std::string& part, uint64_t bytes) {
    ledger_->take(part, bytes);
    void* memory = nullptr;
    cudaError_t error = is_pooled_ ? cudaMallocAsync(&memory, bytes, cudaStreamPerThread) : cudaMalloc(&memory, bytes);
    if (error == cudaSuccess && is_pooled_) error = cudaStreamSynchronize(cudaStreamPerThread);
    if (error != cudaSuccess) {
      ledger_->give_back(part, bytes);
      check_cuda(error, (part + ": " + std::to_string(bytes) + " bytes").c_str());
    }
    return memory;
  }
  /// Nothing in line may use it any more.
  void deallocate(const std::string& part, void* memory, uint64_t bytes) {
    cudaSetDevice(device_);  // the calling thread may be a new one
    is_pooled_ ? cudaFreeAsync(memory, cudaStreamPerThread) : cudaFree(memory);
    ledger_->give_back(part, bytes);
  }
  const std::shared_ptr<MemoryLedger>& ledger() const { return ledger_; }

 private:
  int device_;
  std::shared_ptr<MemoryLedger> ledger_;
  bool is_pooled_;
};

/// For an answer: pinned, aligned to 64 bytes, booked nowhere. `device` is the calling thread's.
inline std::shared_ptr<std::byte> pinned_block(int device, uint64_t bytes) {
  void* memory = nullptr;
  check_cuda(cudaHostAlloc(&memory, bytes, cudaHostAllocDefault),
             ("answer: " + std::to_string(bytes) + " bytes of pinned host memory").c_str());
  return {static_cast<std::byte*>(memory), [device](std::byte* block) {
            cudaSetDevice(device);  // another one might not be in use yet, and would be made ready
            cudaFreeHost(block);
          }};
}

/// Memory of the host that the device reads and writes directly, booked in a scene's ledger. From any thread.
class PinnedMemory {
 public:
  explicit PinnedMemory(std::shared_ptr<MemoryLedger> ledger) : ledger_(std::move(ledger)) {}

  void* allocate(const std::string& part, uint64_t bytes) {
    ledger_->take_pinned(bytes);
    void* memory = nullptr;
    const cudaError_t error = cudaHostAlloc(&memory, bytes, cudaHostAllocDefault);
    if (error != cudaSuccess) {
      ledger_->give_back_pinned(bytes);
      check_cuda(error, (part + ": " + std::to_string(bytes) + " bytes of pinned host memory").c_str());
    }
    return memory;
  }
  void deallocate(const std::string&, void* memory, uint64_t bytes) {
    cudaFreeHost(memory);
    ledger_->give_back_pinned(bytes);
  }

 private:
  std::shared_ptr<MemoryLedger> ledger_;
};

/// Does not wait for the default stream, nor it for this.
class CudaStream {
 public:
  CudaStream() { check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate"); }
  CudaStream(const CudaStream&) = delete;
  CudaStream& operator=(const CudaStream&) = delete;
  ~CudaStream() { cudaStreamDestroy(stream_); }
  operator cudaStream_t() const { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

/// Takes no time.
class CudaEvent {
 public:
  CudaEvent() { check_cuda(cudaEventCreateWithFlags(&event_, cudaEventDisableTiming), "cudaEventCreate"); }
  CudaEvent(const CudaEvent&) = delete;
  CudaEvent& operator=(const CudaEvent&) = delete;
  ~CudaEvent() { cudaEventDestroy(event_); }
  operator cudaEvent_t() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

}  // namespace collided
