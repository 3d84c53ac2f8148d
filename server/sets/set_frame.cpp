#include "server/sets/set_frame.hpp"

#include <cstring>
#include <numeric>

#include "server/convert/options.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

using Ids = google::protobuf::RepeatedField<uint32_t>;

// What a message has of a set's frame.
struct Parts {
  const Ids &worlds, &meshes;
  std::span<const std::byte> ends, starts;
  std::string path;  // of what the positions are in
};

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

[[noreturn]] void throw_size(const Parts& frame, uint64_t worlds, uint64_t vertices, uint64_t moving,
                             const SceneSpec& set) {
  const uint64_t of_vertex = position_bytes(set);
  std::string what = fmt::format("has {} bytes; {} {} of {} vertices, {} bytes each, are {}", frame.ends.size(), worlds,
                                 worlds == 1 ? "world" : "worlds", vertices, of_vertex, worlds * vertices * of_vertex);
  if (moving != vertices)
    what += fmt::format(", and those of the {} vertices that are not static {}", moving, worlds * moving * of_vertex);
  throw_invalid(frame.path + ".positions", what);
}

// The meshes that the positions are of.
std::vector<uint32_t> parse_meshes(const Parts& frame, uint64_t worlds, const SceneSpec& set) {
  std::vector<uint32_t> meshes =
      parse_ids(frame.meshes, static_cast<uint32_t>(set.meshes.size()), "frame.meshes", "meshes");
  const auto bytes_of = [&](uint64_t vertices) { return worlds * vertices * position_bytes(set); };
  const uint64_t bytes = frame.ends.size(), all = vertices_of(set, meshes);
  if (bytes == bytes_of(all) && bytes > 0) return meshes;
  if (!frame.meshes.empty()) throw_size(frame, worlds, all, all, set);
  meshes = moving_meshes(set);
  const uint64_t moving = vertices_of(set, meshes);
  if (bytes != bytes_of(moving) || bytes == 0) throw_size(frame, worlds, all, moving, set);
  return meshes;
}

void check_starts(const Parts& frame, const SceneSpec& set) {
  const std::string path = frame.path + ".start_positions";
  if (frame.starts.empty()) return;
  if (set.mode == Mode::kDcd) throw_invalid(path, "is given, but the set is DCD");
  if (frame.starts.size() != frame.ends.size())
    throw_invalid(path, fmt::format("has {} bytes, but positions has {}", frame.starts.size(), frame.ends.size()));
}

void parse_options(const pb::SetFrame& frame, const SceneSpec& set, FrameInput& input) {
  if (frame.mode() != pb::DETECTION_MODE_UNSPECIFIED) input.mode = parse_mode(frame.mode(), "frame.mode");
  input.accuracy = parse<Accuracy>(frame.accuracy(), "frame.accuracy");
  if (frame.has_delta()) input.delta = frame.delta();
  check_frame_options(set, input);
}

// Gives each world its part of the positions.
void divide(const Parts& frame, const SceneSpec& set, SetFrameInput& parsed) {
  parsed.worlds = parse_ids(frame.worlds, set.worlds, "frame.worlds", "worlds");
  parsed.meshes = parse_meshes(frame, parsed.worlds.size(), set);
  check_starts(frame, set);
  parsed.input.updates.clear();
  parsed.input.updates.reserve(parsed.worlds.size() * parsed.meshes.size());
  size_t at = 0;
  for (const uint32_t world : parsed.worlds)
    for (const uint32_t mesh : parsed.meshes) {
      const size_t bytes = set.meshes[mesh].vertex_count * position_bytes(set);
      MeshPositions& update = parsed.input.updates.emplace_back();
      update.mesh = world * static_cast<uint32_t>(set.meshes.size()) + mesh;
      update.end = frame.ends.subspan(at, bytes);
      if (!frame.starts.empty() && set.meshes[mesh].motion != MeshMotion::kStatic)
        update.start = frame.starts.subspan(at, bytes);
      at += bytes;
    }
}

// What the engine refuses too, by fields of the scene.
void check_has_none(const pb::Frame& frame) {
  const auto refuse = [](const char* field) {
    throw_invalid(field, "is given, but the scene is a set, which has none");
  };
  if (frame.report() != pb::REPORT_UNSPECIFIED && frame.report() != pb::REPORT_ALL) refuse("frame.report");
  if (frame.advance()) refuse("frame.advance");
  if (frame.advance_mode() != pb::ADVANCE_MODE_UNSPECIFIED) refuse("frame.advance_mode");
  if (frame.limits()) refuse("frame.limits");
  if (frame.trial()) refuse("frame.trial");
  if (frame.has_from_last_fraction()) refuse("frame.from_last_fraction");
  if (frame.has_edit()) refuse("frame.edit");
  if (frame.updates_size() != 1)
    throw_invalid("frame.updates", fmt::format("has {} entries, but a set's frame has 1", frame.updates_size()));
  if (frame.updates(0).mesh() != 0)
    throw_invalid(
        "frame.updates[0].mesh",
        fmt::format("is {}, but must be 0: a set's frame names its meshes in `meshes`", frame.updates(0).mesh()));
  if (frame.updates(0).has_sparse()) refuse("frame.updates[0].sparse");
  if (frame.updates(0).has_rigid()) refuse("frame.updates[0].rigid");
}

}  // namespace

SetFrameInput parse_set_frame(const pb::SetFrame& frame, const SceneSpec& set) {
  SetFrameInput parsed;
  parse_options(frame, set, parsed.input);
  divide({frame.worlds(), frame.meshes(), std::as_bytes(std::span(frame.positions())),
          std::as_bytes(std::span(frame.start_positions())), "frame"},
         set, parsed);
  return parsed;
}

SetFrameInput parse_set_frame(const pb::Frame& frame, std::span<const PlacedPositions> placed, const SceneSpec& set) {
  SetFrameInput parsed;
  check_has_none(frame);
  parsed.input = parse_frame(frame, placed, set);
  const MeshPositions all = parsed.input.updates[0];
  divide({frame.worlds(), frame.meshes(), all.end, all.start, "frame.updates[0]"}, set, parsed);
  return parsed;
}

void check_no_worlds(const pb::Frame& frame) {
  if (!frame.worlds().empty()) throw_invalid("frame.worlds", "is given, but the scene is no set");
  if (!frame.meshes().empty()) throw_invalid("frame.meshes", "is given, but the scene is no set");
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
