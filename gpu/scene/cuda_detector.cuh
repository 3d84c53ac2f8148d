#pragma once
#include "gpu/exec/cuda/cuda_exec.cuh"
#include "gpu/exec/cuda/step_clock.cuh"
#include "gpu/scene/scalar_backends.hpp"
#include "gpu/scene/scene_detector.hpp"
#include "gpu/search/cuda/searcher.cuh"

namespace collided {

template <class Real>
std::unique_ptr<Detector> make_cuda_detector_of(SceneSpec spec, FeatureTables features, const ShardOf* shard) {
  const int device = spec.device.ordinal, threads = spec.threads;
  const MemoryLimits memory(spec.memory_budget, spec.memory_quota);
  return std::make_unique<SceneDetector<CudaExec, Real>>(std::move(spec), std::move(features), shard, device, threads,
                                                         memory);
}

// Where kernels are loaded lazily, the first one that is asked for brings those of its module: all of this file's.
template <class Real>
void load_cuda_kernels_of() {
  cudaFuncAttributes attributes{};
  check_cuda(cudaFuncGetAttributes(&attributes, note_time_kernel), "loading the kernels");
}

}  // namespace collided
