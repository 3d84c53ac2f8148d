// Frames from the protocol to the engine.
#include "server/convert/convert.hpp"
#include "server/convert/convert_level.hpp"
#include "server/convert/refuse.hpp"

namespace collided::server {
namespace {

std::span<const std::byte> as_bytes(const std::string& bytes) { return std::as_bytes(std::span(bytes)); }

}  // namespace

FrameInput parse_frame(const pb::Frame& frame, const SceneSpec& scene) {
  FrameInput input;
  input.accuracy = parse_accuracy(frame.accuracy(), "frame.accuracy");
  if (frame.has_delta()) input.delta = parse_length(frame.delta(), "frame.delta");
  input.report = parse_report(frame.report(), "frame.report");
  check_levels(scene, input);
  for (int i = 0; i < frame.updates_size(); ++i) {
    const auto& update = frame.updates(i);
    if (update.has_sparse()) throw_not_served(fmt::format("frame.updates[{}].sparse", i), "set");
    if (update.has_rigid()) throw_not_served(fmt::format("frame.updates[{}].rigid", i), "set");
    input.updates.push_back({update.mesh(), as_bytes(update.start_positions()), as_bytes(update.positions())});
  }
  return input;
}

uint64_t position_bytes(const pb::Frame& frame) {
  uint64_t bytes = 0;
  for (const auto& update : frame.updates()) bytes += update.positions().size() + update.start_positions().size();
  return bytes;
}

}  // namespace collided::server
