#include "gpu/exec/cuda/cuda_memory.cuh"
#include "gpu/exec/cuda/device.cuh"
#include "gpu/exec/cuda/shared_memory.cuh"
#include "gpu/positions/format.hpp"
#include "gpu/scene/backends/backends.hpp"
#include "gpu/scene/scalar_backends.hpp"

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

std::unique_ptr<Detector> make_cuda_detector(SceneSpec spec, FeatureTables features, const ShardOf* shard) {
  return with_real(spec.scalar, [&]<class Real>(Real) {
    return make_cuda_detector_of<Real>(std::move(spec), std::move(features), shard);
  });
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

void load_cuda_kernels(int ordinal) {
  use_device(ordinal);
  load_cuda_kernels_of<float>();
  load_cuda_kernels_of<double>();
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
