#include <unistd.h>

#include "gpu/backends.hpp"
#include "gpu/exec/cpu_exec.hpp"
#include "gpu/scene_detector.hpp"

namespace collided {

std::unique_ptr<Detector> make_cpu_detector(SceneSpec spec, FeatureTables features) {
  const int threads = spec.threads;
  const uint64_t budget = spec.memory_budget;
  return make_scene_detector<CpuExec>(std::move(spec), std::move(features), threads, budget);
}

DeviceInfo cpu_device() {
  DeviceInfo info = CpuExec(0, 0).device();
  info.memory_bytes = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGE_SIZE));
  return info;
}

}  // namespace collided
