#include "gpu/backends.hpp"
#include "gpu/exec/cuda_exec.cuh"
#include "gpu/scene_detector.hpp"

namespace collided {

std::unique_ptr<Detector> make_cuda_detector(SceneSpec spec, FeatureTables features) {
  if (!cuda_available()) throw DeviceError("backend: no usable CUDA device was found");
  const uint64_t budget = spec.memory_budget;
  return make_scene_detector<CudaExec>(std::move(spec), std::move(features), 0, budget);
}

std::vector<DeviceInfo> cuda_devices() {
  int count = 0;
  if (cudaGetDeviceCount(&count) != cudaSuccess) {
    cudaGetLastError();
    return {};
  }
  std::vector<DeviceInfo> devices;
  for (int i = 0; i < count; ++i) {
    cudaDeviceProp properties{};
    if (cudaGetDeviceProperties(&properties, i) == cudaSuccess)
      devices.push_back({Backend::kCuda, properties.name, properties.totalGlobalMem});
  }
  return devices;
}

}  // namespace collided
