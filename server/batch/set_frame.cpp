#include "server/batch/set_frame.hpp"

#include <cstring>
#include <numeric>

#include "server/convert/options.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

using Ids = google::protobuf::RepeatedField<uint32_t>;

// Strictly ascending ids below `count`; all of them where none are given.
std::vector<uint32_t> parse_ids(const Ids& ids, uint32_t count, const std::string& field, const char* what) {
  std::vector<uint32_t> parsed(ids.begin(), ids.end());
  if (parsed.empty()) {
    parsed.resize(count);
    std::iota(parsed.begin(), parsed.end(), 0u);
  }
  for (size_t i = 0; i < parsed.size(); ++i) {
    if (parsed[i] >= count)
      throw_invalid(fmt::format("{}[{}]", field, i),
                    fmt::format("is {}, but the set has {} {}", parsed[i], count, what));
    if (i > 0 && parsed[i] <= parsed[i - 1])
      throw_invalid(fmt::format("{}[{}]", field, i),
                    fmt::format("is {} after {}; they must ascend strictly", parsed[i], parsed[i - 1]));
  }
  return parsed;
}

uint64_t vertices_of(const SceneSpec& set, const std::vector<uint32_t>& meshes) {
  uint64_t vertices = 0;
  for (const uint32_t mesh : meshes) vertices += set.meshes[mesh].vertex_count;
  return vertices;
}

std::vector<uint32_t> moving_meshes(const SceneSpec& set) {
  std::vector<uint32_t> moving;
  for (uint32_t mesh = 0; mesh < set.meshes.size(); ++mesh)
    if (set.meshes[mesh].motion != MeshMotion::kStatic) moving.push_back(mesh);
  return moving;
}

[[noreturn]] void throw_size(uint64_t bytes, uint64_t worlds, uint64_t vertices, uint64_t moving,
                             const SceneSpec& set) {
  const uint64_t of_vertex = position_bytes(set);
  std::string what = fmt::format("has {} bytes; {} {} of {} vertices, {} bytes each, are {}", bytes, worlds,
                                 worlds == 1 ? "world" : "worlds", vertices, of_vertex, worlds * vertices * of_vertex);
  if (moving != vertices)
    what += fmt::format(", and those of the {} vertices that are not static {}", moving, worlds * moving * of_vertex);
  throw_invalid("frame.positions", what);
}

// The meshes that the positions are of.
std::vector<uint32_t> parse_meshes(const pb::SetFrame& frame, uint64_t worlds, const SceneSpec& set) {
  std::vector<uint32_t> meshes =
      parse_ids(frame.meshes(), static_cast<uint32_t>(set.meshes.size()), "frame.meshes", "meshes");
  const auto bytes_of = [&](uint64_t vertices) { return worlds * vertices * position_bytes(set); };
  const uint64_t bytes = frame.positions().size(), all = vertices_of(set, meshes);
  if (bytes == bytes_of(all) && bytes > 0) return meshes;
  if (!frame.meshes().empty()) throw_size(bytes, worlds, all, all, set);
  meshes = moving_meshes(set);
  const uint64_t moving = vertices_of(set, meshes);
  if (bytes != bytes_of(moving) || bytes == 0) throw_size(bytes, worlds, all, moving, set);
  return meshes;
}

void check_starts(const pb::SetFrame& frame, const SceneSpec& set) {
  const size_t starts = frame.start_positions().size();
  if (starts == 0) return;
  if (set.mode == Mode::kDcd) throw_invalid("frame.start_positions", "is given, but the set is DCD");
  if (starts != frame.positions().size())
    throw_invalid("frame.start_positions",
                  fmt::format("has {} bytes, but positions has {}", starts, frame.positions().size()));
}

void parse_options(const pb::SetFrame& frame, const SceneSpec& set, FrameInput& input) {
  if (frame.mode() != pb::DETECTION_MODE_UNSPECIFIED) input.mode = parse_mode(frame.mode(), "frame.mode");
  input.accuracy = parse_accuracy(frame.accuracy(), "frame.accuracy");
  if (frame.has_delta()) input.delta = frame.delta();
  check_frame_options(set, input);
}

}  // namespace

SetFrameInput parse_set_frame(const pb::SetFrame& frame, const SceneSpec& set) {
  SetFrameInput parsed;
  parse_options(frame, set, parsed.input);
  parsed.worlds = parse_ids(frame.worlds(), set.worlds, "frame.worlds", "worlds");
  const std::vector<uint32_t> meshes = parse_meshes(frame, parsed.worlds.size(), set);
  check_starts(frame, set);
  const auto ends = std::as_bytes(std::span(frame.positions())),
             starts = std::as_bytes(std::span(frame.start_positions()));
  parsed.input.updates.reserve(parsed.worlds.size() * meshes.size());
  size_t at = 0;
  for (const uint32_t world : parsed.worlds)
    for (const uint32_t mesh : meshes) {
      const size_t bytes = set.meshes[mesh].vertex_count * position_bytes(set);
      MeshPositions& update = parsed.input.updates.emplace_back();
      update.mesh = world * static_cast<uint32_t>(set.meshes.size()) + mesh;
      update.end = ends.subspan(at, bytes);
      if (!starts.empty() && set.meshes[mesh].motion != MeshMotion::kStatic) update.start = starts.subspan(at, bytes);
      at += bytes;
    }
  return parsed;
}

uint64_t position_bytes_of(const FrameInput& input) {
  uint64_t bytes = 0;
  for (const MeshPositions& update : input.updates) bytes += update.start.size() + update.end.size();
  return bytes;
}

void move_to(std::span<std::byte> room, FrameInput& input) {
  const auto move = [&](std::span<const std::byte>& bytes) {
    if (bytes.empty()) return;
    std::memcpy(room.data(), bytes.data(), bytes.size());
    bytes = room.first(bytes.size());
    room = room.subspan(bytes.size());
  };
  for (MeshPositions& update : input.updates) {
    move(update.start);
    move(update.end);
  }
}

}  // namespace collided::server
