// What a watcher asks for, checked.
#include "server/service/watch_options.hpp"

#include <algorithm>
#include <set>

#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kDoneBytes = 8192;              // of metrics and totals
constexpr uint64_t kBytesOfMesh = 24;              // beside its positions
constexpr double kMinRate = 1e-3, kMaxRate = 1e6;  // messages a second

Clock::duration parse_period(double rate) {
  if (rate == 0) return {};
  if (!(rate >= kMinRate && rate <= kMaxRate))
    throw_invalid("max_frames_per_second",
                  fmt::format("is {}, but must be 0 or from {} to {}", rate, kMinRate, kMaxRate));
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate));
}

std::vector<uint32_t> parse_meshes(const pb::WatchSceneRequest& request, const ScenePlan& plan) {
  std::set<uint32_t> seen;
  for (int i = 0; i < request.position_meshes_size(); ++i) {
    const uint32_t mesh = request.position_meshes(i);
    const std::string field = fmt::format("position_meshes[{}]", i);
    if (mesh >= plan.meshes.size())
      throw_invalid(field, fmt::format("is {}, but the scene has {} meshes", mesh, plan.meshes.size()));
    if (!seen.insert(mesh).second) throw_invalid(field, fmt::format("is {}, which position_meshes has twice", mesh));
  }
  return {request.position_meshes().begin(), request.position_meshes().end()};
}

std::vector<VertexSample> samples_of(const std::vector<uint32_t>& meshes, uint32_t stride, const ScenePlan& plan) {
  std::vector<uint64_t> first{0};  // vertex of each mesh
  for (const MeshSpec& mesh : plan.engine.meshes) first.push_back(first.back() + mesh.vertex_count);
  std::vector<VertexSample> samples;
  for (const uint32_t mesh : meshes)
    samples.push_back({first[mesh], stride, (first[mesh + 1] - first[mesh] + stride - 1) / stride});
  return samples;
}

uint64_t bytes_of(const std::vector<VertexSample>& samples, const ScenePlan& plan) {
  uint64_t bytes = samples.size() * kBytesOfMesh;
  for (const VertexSample& sample : samples) bytes += sample.count * position_bytes(plan.engine.scalar);
  return bytes;
}

// The smallest stride whose positions fit, which a larger one does the more.
uint32_t least_stride(const std::vector<uint32_t>& meshes, const ScenePlan& plan) {
  const auto fits = [&](uint32_t stride) {
    return bytes_of(samples_of(meshes, stride, plan), plan) <= kMaxWatchedPositionBytes;
  };
  uint32_t low = 1, high = 1;
  for (const MeshSpec& mesh : plan.engine.meshes) high = std::max(high, mesh.vertex_count);
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (fits(middle))
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

uint32_t parse_stride(uint32_t stride, const std::vector<uint32_t>& meshes, const ScenePlan& plan) {
  if (meshes.empty()) {
    if (stride > 0) throw_invalid("vertex_stride", fmt::format("is {}, but position_meshes is empty", stride));
    return 0;
  }
  const uint32_t least = least_stride(meshes, plan);
  if (stride > 0 && stride < least)
    throw_invalid("vertex_stride",
                  fmt::format("is {}, but must be {} or more for the positions of position_meshes to take no more than "
                              "{} bytes in a message",
                              stride, least, kMaxWatchedPositionBytes));
  return stride > 0 ? stride : least;
}

}  // namespace

WatchOptions parse_watch(const pb::WatchSceneRequest& request, const ScenePlan& plan) {
  WatchOptions options;
  options.frame_interval = std::max(1u, request.frame_interval());
  options.period = parse_period(request.max_frames_per_second());
  options.max_contacts = request.max_contacts_per_kind();
  if (options.max_contacts > kMaxWatchedContacts)
    throw_invalid("max_contacts_per_kind",
                  fmt::format("is {}, more than {}", options.max_contacts, kMaxWatchedContacts));
  options.meshes = parse_meshes(request, plan);
  const uint32_t stride = parse_stride(request.vertex_stride(), options.meshes, plan);
  if (stride > 0) options.samples = {stride, samples_of(options.meshes, stride, plan)};
  return options;
}

VertexSamples samples_after_edit(const WatchOptions& options, const ScenePlan& plan) {
  if (options.meshes.empty()) return {};
  const uint32_t stride = std::max(options.samples.stride, least_stride(options.meshes, plan));
  return {stride, samples_of(options.meshes, stride, plan)};
}

uint64_t max_watch_message_bytes(const WatchOptions& options, const VertexSamples& samples, const ScenePlan& plan) {
  uint64_t kinds = 0;
  for_each_kind([&](ContactKind, bool is_wanted) { kinds += is_wanted ? 1 : 0; }, plan.engine.kinds);
  return kDoneBytes + kinds * options.max_contacts * plan.fields.contact_bytes() + bytes_of(samples.of_mesh, plan);
}

}  // namespace collided::server
