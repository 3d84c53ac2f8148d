#include "gpu/exec/cuda/cuda_exec.cuh"
#include "gpu/exec/cuda/device.cuh"
#include "gpu/exec/cuda/shared_memory.cuh"
#include "gpu/exec/cuda/step_clock.cuh"
#include "gpu/scene/backends.hpp"
#include "gpu/scene/scene_detector.hpp"
#include "gpu/search/cuda/searcher.cuh"

namespace collided {

namespace {

void link_to(int device, int other) {
  int can_access = 0;
  if (device == other || cudaDeviceCanAccessPeer(&can_access, device, other) != cudaSuccess || can_access == 0) return;
  use_device(device);
  const cudaError_t error = cudaDeviceEnablePeerAccess(other, 0);
  if (error == cudaErrorPeerAccessAlreadyEnabled)
    cudaGetLastError();
  else
    check_cuda(error, "cudaDeviceEnablePeerAccess");
}

}  // namespace

std::unique_ptr<Detector> make_cuda_detector(SceneSpec spec, FeatureTables features, const PartOf* part) {
  const int device = spec.device.ordinal, threads = spec.threads;
  const MemoryLimits memory(spec.memory_budget, spec.memory_quota);
  return make_scene_detector<CudaExec>(std::move(spec), std::move(features), part, device, threads, memory);
}

AnswerRoom::MakeBlock cuda_host_blocks(int device) {
  return [device](uint64_t bytes) {
    use_device(device);
    return pinned_block(device, bytes);
  };
}

void link_cuda_devices(const std::vector<Device>& devices) {
  for (const Device& device : devices)
    for (const Device& other : devices) link_to(device.ordinal, other.ordinal);
}

// Where kernels are loaded lazily, the first one that is asked for brings those of its module: all of the engine's.
void load_cuda_kernels(int ordinal) {
  use_device(ordinal);
  cudaFuncAttributes attributes{};
  check_cuda(cudaFuncGetAttributes(&attributes, note_time_kernel), "loading the kernels");
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
