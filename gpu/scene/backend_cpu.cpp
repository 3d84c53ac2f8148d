#include "gpu/exec/cpu/cpu_exec.hpp"
#include "gpu/scene/backends.hpp"
#include "gpu/scene/scene_detector.hpp"
#include "gpu/search/cpu/searcher.hpp"

namespace collided {

std::unique_ptr<Detector> make_cpu_detector(SceneSpec spec, FeatureTables features, const PartOf* part) {
  const int threads = spec.threads;
  const MemoryLimits memory(spec.memory_budget, spec.memory_quota);
  return make_scene_detector<CpuExec>(std::move(spec), std::move(features), part, threads, memory);
}

AnswerRoom::MakeBlock cpu_host_blocks() { return &CpuExec::host_block; }

DeviceInfo cpu_device(int threads) { return CpuExec(threads, 0).device(); }

}  // namespace collided
