#include "gpu/scene/backends/backends.hpp"

namespace collided {

std::unique_ptr<Detector> make_cuda_detector(SceneSpec, FeatureTables, const ShardOf*) {
  throw DeviceError("device: this build has no CUDA");
}
AnswerRoom::MakeBlock cuda_host_blocks(int) { throw DeviceError("device: this build has no CUDA"); }
void link_cuda_devices(const std::vector<Device>&) {}
std::vector<DeviceInfo> cuda_devices() { return {}; }
std::vector<UnusableDevice> unusable_cuda_devices() { return {}; }

std::string why_no_cuda() { return "this build has no CUDA"; }
void load_cuda_kernels(int) { throw DeviceError("device: this build has no CUDA"); }
void check_cuda_ordinal(int) { throw DeviceError("device: this build has no CUDA"); }
uint64_t free_cuda_memory(int) { throw DeviceError("device: this build has no CUDA"); }
bool cuda_works(int) { return false; }
std::unique_ptr<SharedMemory> register_cuda_memory(int, std::span<std::byte>) {
  throw DeviceError("device: this build has no CUDA");
}
std::optional<int> current_cuda_device() { return std::nullopt; }
void set_current_cuda_device(int) {}
void check_cuda_memory(int, std::span<const std::byte>, const std::string&) {
  throw DeviceError("device: this build has no CUDA");
}
std::unique_ptr<SharedMemory> open_cuda_memory(int, std::span<const std::byte>) {
  throw InvalidInput("handle", "handle is of device memory, but this build has no CUDA");
}

}  // namespace collided
