#pragma once
// What a step found, in memory of the host. The device writes it there and then its number, which the host looks at
// without a call of the driver: threads that wait for steps of other scenes would be in each other's way there.

#include <cuda_runtime.h>

#include <atomic>

#include "gpu/exec/buffer.hpp"
#include "gpu/exec/cuda/cuda_memory.cuh"

namespace collided {

constexpr unsigned kAnswerBlock = 256;

/// One block. `to` is [number, first, second] in pinned memory of the host; lengths in words of 64 bits.
inline __global__ void __launch_bounds__(kAnswerBlock)
    answer_kernel(uint64_t number, Span<const uint64_t> first, Span<const uint64_t> second, uint64_t* to) {
  for (uint64_t i = threadIdx.x; i < first.size(); i += kAnswerBlock) to[1 + i] = first[i];
  for (uint64_t i = threadIdx.x; i < second.size(); i += kAnswerBlock) to[1 + first.size() + i] = second[i];
  __threadfence_system();
  __syncthreads();
  if (threadIdx.x == 0) *static_cast<volatile uint64_t*>(to) = number;
}

class StepAnswer {
 public:
  explicit StepAnswer(PinnedMemory& pinned) : host_(pinned, "downloads") {}

  /// Puts in line what brings both to the host.
  void send(cudaStream_t stream, Span<const uint64_t> first, Span<const uint64_t> second) {
    const uint64_t words = 1 + first.size() + second.size();
    if (words > host_.capacity()) {
      host_.allocate(words);
      *host_.data() = 0;
    }
    answer_kernel<<<1, kAnswerBlock, 0, stream>>>(++number_, first, second, host_.data());
    check_cuda(cudaGetLastError(), "answer");
  }
  bool has_come() const { return std::atomic_ref<uint64_t>(*host_.data()).load(std::memory_order_acquire) == number_; }
  const uint64_t* first() const { return host_.data() + 1; }
  const uint64_t* second(uint64_t first_words) const { return first() + first_words; }

 private:
  Buffer<uint64_t, PinnedMemory> host_;
  uint64_t number_ = 0;  ///< of the last one that was sent
};

}  // namespace collided
