#include "gpu/detector.hpp"

#include <cstdlib>

#include "gpu/base/float_environment.hpp"
#include "gpu/exec/asks.hpp"
#include "gpu/scene/backends/backends.hpp"
#include "gpu/scene/known_lengths.hpp"
#include "gpu/scene/rules.hpp"
#include "gpu/scene/shards/sharded_scene.hpp"
#include "gpu/tables/solids.hpp"
#include "gpu/tables/tables.hpp"

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

/// Only an edit leaves a mesh without vertices.
void check_meshes(const SceneSpec& spec) {
  for (size_t i = 0; i < spec.meshes.size(); ++i) {
    const std::string field = "meshes[" + std::to_string(i) + "].vertex_count";
    if (spec.meshes[i].vertex_count == 0) throw InvalidInput(field, field + " is 0, at least 1 is needed");
  }
}

void check_solid_meshes(const SceneSpec& spec) {
  for (const uint32_t mesh : solid_meshes(spec)) check_solid(spec.meshes[mesh], "meshes[" + std::to_string(mesh) + "]");
}

void check_devices(const SceneSpec& spec) {
  if (spec.part_devices.empty()) return check_device(spec.device);
  for (size_t k = 0; k < spec.part_devices.size(); ++k) {
    const std::string field = "part_devices[" + std::to_string(k) + "]";
    try {
      check_device(spec.part_devices[k]);
    } catch (const InvalidInput& e) {
      throw InvalidInput(field, field + ": " + e.what());
    }
  }
}

/// All worlds together.
void check_size(const SceneSpec& spec, const Topology& topology) {
  const uint64_t vertices = uint64_t{spec.worlds} * topology.vertex_count,
                 elements = uint64_t{spec.worlds} * topology.triangles.size();
  if (vertices > kMaxFeatures || elements > kMaxFeatures)
    throw InvalidInput("worlds", "worlds is " + std::to_string(spec.worlds) + ", which together have " +
                                     std::to_string(vertices) + " vertices and " + std::to_string(elements) +
                                     " elements; the limit of each is " + std::to_string(kMaxFeatures));
}

}  // namespace

std::unique_ptr<Detector> Detector::create(SceneSpec spec, std::function<bool()> cancelled) {
  const DefaultFloatEnvironment environment;  // threads that this starts inherit it
  check_spec(spec);
  check_devices(spec);
  check_meshes(spec);
  check_exclusions(spec);
  MemoryHold making(spec.memory_quota);
  Asks asks;
  asks.begin(std::move(cancelled));
  FeatureTables features = make_tables(spec, making, asks);
  check_size(spec, features.topology);
  check_solid_meshes(spec);
  if (!spec.part_devices.empty()) return make_sharded_scene(std::move(spec), std::move(features));
  expect_known_lengths(spec, features.topology);
  return spec.device.backend == Backend::kCuda ? make_cuda_detector(std::move(spec), std::move(features))
                                               : make_cpu_detector(std::move(spec), std::move(features));
}

void check_options(const SceneSpec& spec) { check_spec(spec); }

void check_options_of_frame(const SceneSpec& spec, const FrameInput& frame) { check_frame(spec, frame); }

std::vector<DeviceInfo> list_devices(int threads) {
  std::vector<DeviceInfo> devices{cpu_device(threads)};
  for (DeviceInfo& device : cuda_devices()) devices.push_back(std::move(device));
  return devices;
}

std::vector<UnusableDevice> unusable_devices() { return unusable_cuda_devices(); }

void load_kernels(const Device& device) {
  if (device.backend == Backend::kCuda) load_cuda_kernels(device.ordinal);
}

void load_kernels_at_start() { setenv("CUDA_MODULE_LOADING", "EAGER", 0); }

bool cuda_available() { return !cuda_devices().empty(); }

std::string cuda_obstacle() { return why_no_cuda(); }

void check_device(const Device& device) {
  if (device.ordinal < 0) throw InvalidInput("device", "device is " + to_string(device) + ", ordinals begin at 0");
  if (device.backend == Backend::kCuda) check_cuda_ordinal(device.ordinal);
}

uint64_t free_device_memory(const Device& device) {
  return device.backend == Backend::kCpu ? 0 : free_cuda_memory(device.ordinal);
}

bool device_works(const Device& device) { return device.backend == Backend::kCpu || cuda_works(device.ordinal); }

std::unique_ptr<SharedMemory> register_host_memory(const Device& device, std::span<std::byte> memory) {
  if (device.backend == Backend::kCuda) return register_cuda_memory(device.ordinal, memory);
  return std::make_unique<HostMemoryOfOthers>(memory);
}

KeptCudaDevice::KeptCudaDevice(const Device& device) {
  if (device.backend == Backend::kCuda) ordinal_ = current_cuda_device();
}
KeptCudaDevice::~KeptCudaDevice() {
  if (ordinal_) set_current_cuda_device(*ordinal_);
}

void check_device_memory(const Device& device, std::span<const std::byte> memory, const std::string& field) {
  if (device.backend == Backend::kCuda && !memory.empty()) check_cuda_memory(device.ordinal, memory, field);
}

std::unique_ptr<SharedMemory> open_device_memory(const Device& device, std::span<const std::byte> handle) {
  if (device.backend == Backend::kCpu)
    throw InvalidInput("handle", "handle is of device memory, but the scene lives on " + to_string(device));
  return open_cuda_memory(device.ordinal, handle);
}

}  // namespace collided
