#pragma once
// Records loops of a step. The device decides after each round whether another one follows, so the host waits only for
// the last.

#include <cuda_runtime.h>

#include "gpu/exec/cuda/memory/cuda_call.cuh"

namespace collided {

/// Tells whether graphs have loops. CUDA 12 runs with drivers that do not know them.
constexpr bool kRecordsLoops = CUDART_VERSION >= 13000;

#if CUDART_VERSION >= 13000

inline __global__ void set_condition_kernel(cudaGraphConditionalHandle goes_on, const uint64_t* again) {
  cudaGraphSetConditional(goes_on, *again != 0 ? 1 : 0);
}

/// Records a loop on `stream`. body() puts one round in line on `inner`, an idle stream that is part of no recording.
/// The loop goes on as long as a round leaves a value other than 0 at `again`.
template <class F>
void record_loop(cudaStream_t stream, cudaStream_t inner, const uint64_t* again, const F& body) {
  cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
  cudaGraph_t graph = nullptr;
  const cudaGraphNode_t* after = nullptr;
  const cudaGraphEdgeData* edges = nullptr;
  size_t count = 0;
  check_cuda(cudaStreamGetCaptureInfo(stream, &status, nullptr, &graph, &after, &edges, &count), "loop");

  cudaGraphConditionalHandle goes_on{};
  check_cuda(cudaGraphConditionalHandleCreate(&goes_on, graph, 1, cudaGraphCondAssignDefault), "loop");
  cudaGraphNodeParams loop{};
  loop.type = cudaGraphNodeTypeConditional;
  loop.conditional.handle = goes_on;
  loop.conditional.type = cudaGraphCondTypeWhile;
  loop.conditional.size = 1;
  cudaGraphNode_t node = nullptr;
  check_cuda(cudaGraphAddNode(&node, graph, after, edges, count, &loop), "loop");

  cudaGraph_t rounds = loop.conditional.phGraph_out[0];
  check_cuda(cudaStreamBeginCaptureToGraph(inner, rounds, nullptr, nullptr, 0, cudaStreamCaptureModeThreadLocal),
             "loop");
  try {
    body();
    set_condition_kernel<<<1, 1, 0, inner>>>(goes_on, again);
    check_cuda(cudaGetLastError(), "loop");
  } catch (...) {
    cudaStreamEndCapture(inner, &rounds);
    cudaGetLastError();
    throw;
  }
  check_cuda(cudaStreamEndCapture(inner, &rounds), "loop");
  check_cuda(cudaStreamUpdateCaptureDependencies(stream, &node, nullptr, 1, cudaStreamSetCaptureDependencies), "loop");
}

#else

template <class F>
void record_loop(cudaStream_t, cudaStream_t, const uint64_t*, const F&) {
  throw DeviceError("loops are not recorded with CUDA 12");
}

#endif

}  // namespace collided
