// Frames from the protocol to the engine.
#include <spdlog/fmt/fmt.h>

#include "server/convert.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

std::span<const std::byte> as_bytes(const std::string& bytes) { return std::as_bytes(std::span(bytes)); }

[[noreturn]] void throw_not_served(const std::string& field) {
  throw Unimplemented(field, field + " is set, which is not served");
}

}  // namespace

FrameInput parse_frame(const pb::Frame& frame) {
  if (frame.accuracy() != pb::ACCURACY_UNSPECIFIED) throw_not_served("frame.accuracy");
  FrameInput input;
  for (int i = 0; i < frame.updates_size(); ++i) {
    const auto& update = frame.updates(i);
    if (update.has_sparse()) throw_not_served(fmt::format("frame.updates[{}].sparse", i));
    if (update.has_rigid()) throw_not_served(fmt::format("frame.updates[{}].rigid", i));
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
