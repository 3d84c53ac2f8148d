#pragma once
#include "gpu/exec/cpu/cpu_exec.hpp"
#include "gpu/scene/scalar_backends.hpp"
#include "gpu/scene/scene_detector.hpp"
#include "gpu/search/cpu/searcher.hpp"

namespace collided {

template <class Real>
std::unique_ptr<Detector> make_cpu_detector_of(SceneSpec spec, FeatureTables features, const ShardOf* shard) {
  const int threads = spec.threads;
  const MemoryLimits memory(spec.memory_budget, spec.memory_quota);
  return std::make_unique<SceneDetector<CpuExec, Real>>(std::move(spec), std::move(features), shard, threads, memory);
}

}  // namespace collided
