// Frames from the protocol to the engine.
#include "server/convert/convert.hpp"
#include "server/convert/convert_level.hpp"
#include "server/convert/refuse.hpp"

namespace collided::server {
namespace {

std::span<const std::byte> either(std::span<const std::byte> placed, const std::string& bytes) {
  return placed.empty() ? std::as_bytes(std::span(bytes)) : placed;
}

void check_served(const pb::MeshUpdate& update, int index) {
  const auto path = [&](const char* field) { return fmt::format("frame.updates[{}].{}", index, field); };
  if (update.has_rigid()) throw_not_served(path("rigid"), "set");
  const char* why = "is set, but there is no shared memory on this stream";
  if (update.has_shared_positions()) throw_invalid(path("shared_positions"), why);
  if (update.has_shared_start_positions()) throw_invalid(path("shared_start_positions"), why);
  if (update.sparse().has_shared_indices()) throw_invalid(path("sparse.shared_indices"), why);
}

MeshPositions parse_update(const pb::MeshUpdate& update, const PlacedPositions& placed) {
  MeshPositions positions;
  positions.mesh = update.mesh();
  positions.start = either(placed.start, update.start_positions());
  positions.end = either(placed.end, update.positions());
  positions.is_sparse = update.has_sparse();
  positions.indices = either(placed.indices, update.sparse().indices());
  return positions;
}

}  // namespace

PendingFrame parse_frame(const pb::Frame& frame, std::span<const PlacedPositions> placed, const SceneSpec& scene) {
  PendingFrame pending;
  pending.frame_id = frame.frame_id();
  FrameInput& input = pending.input;
  input.accuracy = parse_accuracy(frame.accuracy(), "frame.accuracy");
  if (frame.has_delta()) input.delta = parse_length(frame.delta(), "frame.delta");
  input.report = parse_report(frame.report(), "frame.report");
  check_levels(scene, input);
  for (int i = 0; i < frame.updates_size(); ++i) {
    check_served(frame.updates(i), i);
    const auto index = static_cast<size_t>(i);
    const auto positions = parse_update(frame.updates(i), index < placed.size() ? placed[index] : PlacedPositions{});
    pending.brings.push_back({positions.mesh, !positions.is_sparse});
    pending.bytes_in += positions.start.size() + positions.end.size() + positions.indices.size();
    input.updates.push_back(positions);
  }
  return pending;
}

}  // namespace collided::server
