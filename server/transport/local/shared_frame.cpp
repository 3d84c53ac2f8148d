// A frame whose positions are in shared memory.
#include "server/transport/local/shared_frame.hpp"

#include <string>

#include "server/frames/decode.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

std::span<const std::byte> resolve(const SharedRegion* region, const pb::SharedRange& range, const std::string& path) {
  if (region) return region->input(range.offset(), range.size(), path);
  throw_invalid(path, "is set, but this stream shares no memory");
}

// `shared`: the range, or null; `own`: the message's own bytes, which the range replaces.
std::span<const std::byte> place(const SharedRegion* region, const pb::SharedRange* shared, const std::string& own,
                                 const std::string& path) {
  if (!shared) return {};
  if (!own.empty()) throw_invalid(path, fmt::format("is set, and {} bytes came with the message, too", own.size()));
  return resolve(region, *shared, path);
}

PlacedPositions place_update(const SharedRegion* region, pb::MeshUpdate& update, const std::string& path) {
  PlacedPositions placed;
  placed.end = place(region, update.has_shared_positions() ? &update.shared_positions() : nullptr, update.positions(),
                     path + ".shared_positions");
  placed.start = place(region, update.has_shared_start_positions() ? &update.shared_start_positions() : nullptr,
                       update.start_positions(), path + ".shared_start_positions");
  if (update.has_sparse())
    placed.indices = place(region, update.sparse().has_shared_indices() ? &update.sparse().shared_indices() : nullptr,
                           update.sparse().indices(), path + ".sparse.shared_indices");
  update.clear_shared_positions();
  update.clear_shared_start_positions();
  if (update.has_sparse()) update.mutable_sparse()->clear_shared_indices();
  return placed;
}

}  // namespace

void place_ranges(const SharedRegion* region, IncomingFrame& frame) {
  const auto count = static_cast<size_t>(frame.message.updates_size());
  try {
    frame.placed.reserve(count);
    for (size_t i = 0; i < count; ++i)
      frame.placed.push_back(place_update(region, *frame.message.mutable_updates(static_cast<int>(i)),
                                          fmt::format("frame.updates[{}]", i)));
  } catch (...) {
    frame.refusal = std::current_exception();
  }
}

pb::Frame read_frame(const SharedRegion* region, const pb::SharedRange& range, const ScenePlan& plan,
                     MemoryHold& copied) {
  constexpr auto kPath = "shared_frame";
  const auto bytes = resolve(region, range, kPath);
  if (!region->is_host()) throw_invalid(kPath, "is set, but the input region is memory of the device");
  copied.resize(2 * bytes.size());  // the copy, and what is parsed of it
  const std::string copy(reinterpret_cast<const char*>(bytes.data()),
                         bytes.size());  // the client may still write there
  return parse_bounded_frame(copy, plan.meshes.size(), plan.engine.worlds, kPath);
}

}  // namespace collided::server
