#pragma once
// The backends that this build has; one source file makes each.

#include "gpu/contacts/answer_room.hpp"
#include "gpu/detector.hpp"
#include "gpu/scene/shards/meeting.hpp"
#include "gpu/tables/topology.hpp"

namespace collided {

/// `shard`: the scene is a shard of another; null: it is one.
std::unique_ptr<Detector> make_cpu_detector(SceneSpec spec, FeatureTables features, const ShardOf* shard = nullptr);

/// Throws DeviceError where there is no usable device, or the build has no CUDA.
std::unique_ptr<Detector> make_cuda_detector(SceneSpec spec, FeatureTables features, const ShardOf* shard = nullptr);

/// What makes memory of the host that a backend brings contacts to.
AnswerRoom::MakeBlock cpu_host_blocks();
AnswerRoom::MakeBlock cuda_host_blocks(int device);

/// Lets these devices copy from each other's memory without the host, as far as they can.
void link_cuda_devices(const std::vector<Device>& devices);

/// `threads`: 0: all cores.
DeviceInfo cpu_device(int threads);
std::vector<DeviceInfo> cuda_devices();
std::vector<UnusableDevice> unusable_cuda_devices();

// As in detector.hpp, on CUDA.
std::string why_no_cuda();
void load_cuda_kernels(int ordinal);
void check_cuda_ordinal(int ordinal);
uint64_t free_cuda_memory(int ordinal);
bool cuda_works(int ordinal);
std::unique_ptr<SharedMemory> register_cuda_memory(int ordinal, std::span<std::byte> memory);
std::optional<int> current_cuda_device();
void set_current_cuda_device(int ordinal);
void check_cuda_memory(int ordinal, std::span<const std::byte> memory, const std::string& field);
std::unique_ptr<SharedMemory> open_cuda_memory(int ordinal, std::span<const std::byte> handle);

}  // namespace collided
