#pragma once
// Memory, streams and events of CUDA, each owned by an object.

#include <cuda_runtime.h>

#include <memory>
#include <string>
#include <utility>

#include "gpu/exec/cuda/memory/cuda_call.cuh"
#include "gpu/exec/cuda/memory/device_pool.cuh"
#include "gpu/exec/cuda/memory/pinned_pool.cuh"
#include "gpu/exec/memory_ledger.hpp"

namespace collided {

/// Memory of the device, booked in a scene's ledger. From any thread.
class DeviceMemory {
 public:
  /// `device` is the calling thread's.
  DeviceMemory(int device, std::shared_ptr<MemoryLedger> ledger)
      : device_(device), ledger_(std::move(ledger)), pool_(DevicePool::of(device)) {}

  /// For any stream from then on. `device` is the calling thread's.
  void* allocate(const std::string& part, uint64_t bytes) {
    ledger_->take(part, bytes);
    try {
      return pool_.allocate(bytes, (part + ": " + std::to_string(bytes) + " bytes").c_str());
    } catch (...) {
      ledger_->give_back(part, bytes);
      throw;
    }
  }
  /// Nothing in line may use it any more.
  void deallocate(const std::string& part, void* memory, uint64_t bytes) {
    cudaSetDevice(device_);  // the calling thread may be a new one
    pool_.deallocate(memory);
    ledger_->give_back(part, bytes);
  }
  const std::shared_ptr<MemoryLedger>& ledger() const { return ledger_; }

 private:
  int device_;
  std::shared_ptr<MemoryLedger> ledger_;
  DevicePool& pool_;
};

inline std::string pinned_text(const std::string& part, uint64_t bytes) {
  return part + ": " + std::to_string(bytes) + " bytes of pinned host memory";
}

/// For an answer: pinned, aligned to 64 bytes, booked nowhere. `device` is the calling thread's.
inline std::shared_ptr<std::byte> pinned_block(int device, uint64_t bytes) {
  std::byte* const memory = PinnedPool::instance().allocate(bytes, pinned_text("answer", bytes).c_str());
  return {memory, [device](std::byte* block) {
            cudaSetDevice(device);  // another one might not be in use yet, and would be made ready
            PinnedPool::instance().deallocate(block);
          }};
}

/// Memory of the host that the device reads and writes directly, booked in a scene's ledger. From any thread.
class PinnedMemory {
 public:
  explicit PinnedMemory(std::shared_ptr<MemoryLedger> ledger) : ledger_(std::move(ledger)) {}

  void* allocate(const std::string& part, uint64_t bytes) {
    ledger_->take_pinned(bytes);
    try {
      return PinnedPool::instance().allocate(bytes, pinned_text(part, bytes).c_str());
    } catch (...) {
      ledger_->give_back_pinned(bytes);
      throw;
    }
  }
  void deallocate(const std::string&, void* memory, uint64_t bytes) {
    PinnedPool::instance().deallocate(static_cast<std::byte*>(memory));
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
