#pragma once
// The calling thread waits for what is in line on a stream, and asks meanwhile whether the frame goes on. If anything
// ends the frame, what is in line drains: the loops that take long see the stop word.

#include <cuda_runtime.h>

#include "gpu/exec/asks.hpp"
#include "gpu/exec/cuda/awake.cuh"
#include "gpu/exec/cuda/step_answer.cuh"
#include "gpu/exec/cuda/stop_word.cuh"

namespace collided {

inline bool is_drained(cudaStream_t stream) {
  const cudaError_t state = cudaStreamQuery(stream);
  if (state != cudaErrorNotReady) check_cuda(state, "step");
  return state == cudaSuccess;
}

/// f(), which puts work in line or waits for it.
template <class F>
void draining_if_thrown(StopWord& stop, cudaStream_t stream, const F& f) {
  try {
    f();
  } catch (const DeviceError&) {
    throw;
  } catch (...) {
    stop.set();
    check_cuda(cudaStreamSynchronize(stream), "wait");
    stop.clear(stream);
    throw;
  }
}

inline void wait_for_answer(const StepAnswer& answer, cudaStream_t stream, Asks& asks) {
  constexpr unsigned kLooks = 1024;  // before the driver is asked, which knows of errors
  const Awake awake;
  for (unsigned look = 1; !answer.has_come(); ++look) {
    if (look % kLooks == 0) is_drained(stream);
    awake.rest(look);
    asks.ask_if_due();
  }
}
inline void wait_until_drained(cudaStream_t stream, Asks& asks) {
  while (!is_drained(stream)) asks.ask_if_due();
}

}  // namespace collided
