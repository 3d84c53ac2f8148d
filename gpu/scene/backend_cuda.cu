#include "gpu/exec/cuda/cuda_exec.cuh"
#include "gpu/exec/cuda/shared_memory.cuh"
#include "gpu/scene/backends.hpp"
#include "gpu/scene/scene_detector.hpp"
#include "gpu/search/cuda/searcher.cuh"

namespace collided {

namespace {
constexpr int kDevice = 0;  ///< that all scenes are on
}

std::unique_ptr<Detector> make_cuda_detector(SceneSpec spec, FeatureTables features) {
  if (!cuda_available()) throw DeviceError("backend: no usable CUDA device was found");
  const int threads = spec.threads;
  const MemoryLimits memory(spec.memory_budget, spec.memory_quota);
  return make_scene_detector<CudaExec>(std::move(spec), std::move(features), kDevice, threads, memory);
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

bool cuda_works() { return does_device_work(kDevice); }

std::unique_ptr<SharedMemory> register_cuda_memory(std::span<std::byte> memory) {
  return std::make_unique<RegisteredMemory>(kDevice, memory);
}

std::unique_ptr<SharedMemory> open_cuda_memory(std::span<const std::byte> handle) {
  if (!cuda_available()) throw InvalidInput("handle", "handle names memory of a GPU, and there is none here");
  return std::make_unique<DeviceMemoryOfOthers>(kDevice, handle);
}

}  // namespace collided
