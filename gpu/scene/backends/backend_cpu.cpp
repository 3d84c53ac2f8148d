#include "gpu/exec/cpu/cpu_exec.hpp"
#include "gpu/positions/format.hpp"
#include "gpu/scene/backends/backends.hpp"
#include "gpu/scene/scalar_backends.hpp"

namespace collided {

std::unique_ptr<Detector> make_cpu_detector(SceneSpec spec, FeatureTables features, const ShardOf* shard) {
  return with_real(spec.scalar, [&]<class Real>(Real) {
    return make_cpu_detector_of<Real>(std::move(spec), std::move(features), shard);
  });
}

AnswerRoom::MakeBlock cpu_host_blocks() { return &CpuExec::host_block; }

DeviceInfo cpu_device(int threads) { return CpuExec(threads, 0).device(); }

}  // namespace collided
