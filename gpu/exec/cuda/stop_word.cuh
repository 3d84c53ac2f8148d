#pragma once
// How the host tells loops that take long that their frame has ended: a word on the device, set beside what is in line.

#include <cuda_runtime.h>

#include <cstdint>

#include "gpu/exec/buffer.hpp"
#include "gpu/exec/cuda/cuda_memory.cuh"

namespace collided {

class StopWord {
 public:
  StopWord(DeviceMemory& memory, PinnedMemory& pinned) : word_(memory, "counters"), one_(pinned, "stop") {
    word_.allocate(1);
    one_.allocate(1);
    *one_.data() = 1;
    clear(stream_);
    check_cuda(cudaStreamSynchronize(stream_), "stop");  // nothing is in line once the memory goes to another scene
  }

  /// On the device; 1: the frame has ended, loops that take long do no more.
  const uint32_t* on_device() const { return word_.data(); }

  void set() {
    check_cuda(cudaMemcpyAsync(word_.data(), one_.data(), sizeof(uint32_t), cudaMemcpyHostToDevice, stream_), "stop");
    check_cuda(cudaStreamSynchronize(stream_), "stop");
  }
  /// Once what is in line on that stream has ended.
  void clear(cudaStream_t stream) { check_cuda(cudaMemsetAsync(word_.data(), 0, sizeof(uint32_t), stream), "stop"); }

 private:
  CudaStream stream_;  // its own, since the others are full
  Buffer<uint32_t, DeviceMemory> word_;
  Buffer<uint32_t, PinnedMemory> one_;
};

}  // namespace collided
