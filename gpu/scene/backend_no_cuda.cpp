#include "gpu/scene/backends.hpp"

namespace collided {

std::unique_ptr<Detector> make_cuda_detector(SceneSpec, FeatureTables) {
  throw DeviceError("backend: this build has no CUDA");
}
std::vector<DeviceInfo> cuda_devices() { return {}; }

bool cuda_works() { return false; }
std::unique_ptr<SharedMemory> register_cuda_memory(std::span<std::byte>) {
  throw DeviceError("backend: this build has no CUDA");
}
std::unique_ptr<SharedMemory> open_cuda_memory(std::span<const std::byte>) {
  throw InvalidInput("handle", "handle is of device memory, but this build has no CUDA");
}

}  // namespace collided
