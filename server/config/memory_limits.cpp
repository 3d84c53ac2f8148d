// Limits left unset, derived from the available memory and from other limits.
#include "server/config/memory_limits.hpp"

#include <algorithm>

namespace collided::server {
namespace {

constexpr uint64_t kMegabyte = uint64_t{1} << 20, kGigabyte = uint64_t{1} << 30;
constexpr uint64_t kUnknownHost = 8 * kGigabyte;

// At least one, as the options count in MiB.
uint64_t whole_megabytes(uint64_t bytes) { return std::max(kMegabyte, bytes / kMegabyte * kMegabyte); }

uint64_t host_memory(const Memory& memory) { return memory.host ? memory.host : kUnknownHost; }

uint64_t scene_memory(const Memory& memory) {
  const uint64_t of_host = host_memory(memory) / 2;
  return memory.device ? std::min(of_host, memory.device / 10 * 9) : of_host;
}

// Messages in transit are short-lived: more than `max` would make nothing faster.
uint64_t in_transit(const Memory& memory, uint64_t max) {
  return std::min(max, whole_megabytes(host_memory(memory) / 8));
}

uint32_t quarter(uint32_t all) { return (all + 3) / 4; }

template <class T>
void fill(T& limit, T derived) {
  if (limit == 0) limit = derived;
}

std::string megabytes(uint64_t bytes) { return std::to_string(bytes / kMegabyte) + " MiB"; }

}  // namespace

Limits underived_limits() {
  Limits limits;
  const auto unset = [](const auto& row, auto& limit) {
    if (row.is_derived()) limit = {};
  };
  for_each_limit(unset, limits);
  return limits;
}

void derive_limits(Limits& limits, const Memory& memory) {
  fill(limits.max_device_bytes, whole_megabytes(scene_memory(memory)));
  fill(limits.client.max_device_bytes, whole_megabytes(limits.max_device_bytes / 4));
  fill(limits.max_scene_bytes, limits.client.max_device_bytes);
  fill(limits.max_decode_bytes, in_transit(memory, 256 * kMegabyte));
  fill(limits.max_network_bytes, in_transit(memory, 512 * kMegabyte));
  fill(limits.client.max_scenes, quarter(limits.max_scenes));
  fill(limits.client.max_streams, quarter(limits.max_streams));
}

uint64_t network_quota(const Limits& limits) {
  return std::max(limits.max_network_bytes, 2 * limits.max_message_bytes);
}

std::string describe_limits(const Limits& limits, const Memory& memory) {
  return "memory: host " + (memory.host ? megabytes(memory.host) : "unknown") +
         (memory.device ? ", device " + megabytes(memory.device) : "") + "; limits: all scenes " +
         megabytes(limits.max_device_bytes) + ", those of a client " + megabytes(limits.client.max_device_bytes) +
         ", one scene " + megabytes(limits.max_scene_bytes) + ", network buffers " +
         megabytes(limits.max_network_bytes) + ", decoded messages " + megabytes(limits.max_decode_bytes) +
         "; a client " + std::to_string(limits.client.max_scenes) + " of " + std::to_string(limits.max_scenes) +
         " scenes, " + std::to_string(limits.client.max_streams) + " of " + std::to_string(limits.max_streams) +
         " streams";
}

}  // namespace collided::server
