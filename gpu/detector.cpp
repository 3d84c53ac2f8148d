#include "gpu/detector.hpp"

#include "gpu/scene/backends.hpp"
#include "gpu/scene/memory_need.hpp"
#include "gpu/scene/rules.hpp"

namespace collided {
namespace {

/// Cores read any memory of the process.
class HostMemoryOfOthers final : public SharedMemory {
 public:
  explicit HostMemoryOfOthers(std::span<std::byte> memory) : memory_(memory) {}
  std::span<std::byte> bytes() const override { return memory_; }

 private:
  std::span<std::byte> memory_;
};

uint64_t elements_of(const SceneSpec& spec) {
  uint64_t elements = 0;
  for (const MeshSpec& mesh : spec.meshes) elements += count_elements(mesh);
  return elements;
}

}  // namespace

std::unique_ptr<Detector> Detector::create(SceneSpec spec) {
  check_spec(spec);
  check_exclusions(spec);
  MemoryHold making(spec.memory_quota);
  making.resize(max_making_bytes(elements_of(spec)));
  FeatureTables features = make_features(spec.meshes);
  making.resize(bytes_of(features));
  features.rings = make_rings(spec, features.topology, making);
  return spec.backend == Backend::kCuda ? make_cuda_detector(std::move(spec), std::move(features))
                                        : make_cpu_detector(std::move(spec), std::move(features));
}

void check_options(const SceneSpec& spec, const FrameInput& frame) {
  check_spec(spec);
  check_frame(spec, frame);
}

std::vector<DeviceInfo> list_devices(int threads) {
  std::vector<DeviceInfo> devices{cpu_device(threads)};
  for (DeviceInfo& device : cuda_devices()) devices.push_back(std::move(device));
  return devices;
}

bool cuda_available() { return !cuda_devices().empty(); }

bool device_works(Backend backend) { return backend == Backend::kCpu || cuda_works(); }

std::unique_ptr<SharedMemory> register_host_memory(Backend backend, std::span<std::byte> memory) {
  if (backend == Backend::kCuda) return register_cuda_memory(memory);
  return std::make_unique<HostMemoryOfOthers>(memory);
}

std::unique_ptr<SharedMemory> open_device_memory(std::span<const std::byte> handle) { return open_cuda_memory(handle); }

}  // namespace collided
