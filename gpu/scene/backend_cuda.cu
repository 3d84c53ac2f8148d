#include "gpu/exec/cuda/cuda_exec.cuh"
#include "gpu/exec/cuda/device.cuh"
#include "gpu/exec/cuda/shared_memory.cuh"
#include "gpu/scene/backends.hpp"
#include "gpu/scene/scene_detector.hpp"
#include "gpu/search/cuda/searcher.cuh"

namespace collided {

std::unique_ptr<Detector> make_cuda_detector(SceneSpec spec, FeatureTables features) {
  const int device = spec.device.ordinal, threads = spec.threads;
  const MemoryLimits memory(spec.memory_budget, spec.memory_quota);
  return make_scene_detector<CudaExec>(std::move(spec), std::move(features), device, threads, memory);
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
    if (cudaGetDeviceProperties(&properties, i) == cudaSuccess) devices.push_back(info_of(i, properties));
  }
  return devices;
}

void check_cuda_ordinal(int ordinal) {
  int count = 0;
  if (cudaGetDeviceCount(&count) == cudaSuccess && ordinal < count) return;
  const std::vector<DeviceInfo> devices = cuda_devices();
  if (devices.empty()) throw DeviceError("device: no usable CUDA device was found");
  std::string there;
  for (const DeviceInfo& info : devices) there += (there.empty() ? "" : ", ") + std::to_string(info.device.ordinal);
  throw InvalidInput("device", "device is " + to_string(cuda_device(ordinal)) + ": this machine has " +
                                   std::to_string(devices.size()) +
                                   (devices.size() == 1 ? " CUDA device (" : " CUDA devices (") + there + ")");
}

uint64_t free_cuda_memory(int ordinal) { return free_bytes_of(ordinal); }

bool cuda_works(int ordinal) { return does_device_work(ordinal); }

std::unique_ptr<SharedMemory> register_cuda_memory(int ordinal, std::span<std::byte> memory) {
  return std::make_unique<RegisteredMemory>(ordinal, memory);
}

std::unique_ptr<SharedMemory> open_cuda_memory(int ordinal, std::span<const std::byte> handle) {
  if (!cuda_available()) throw InvalidInput("handle", "handle names memory of a GPU, and there is none here");
  return std::make_unique<DeviceMemoryOfOthers>(ordinal, handle);
}

}  // namespace collided
