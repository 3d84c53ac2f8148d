#pragma once
// Updates of meshes that own their bytes, and frames' positions put where a test wants them.

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

/// An update of one mesh; view() borrows its bytes.
struct OwnedUpdate {
  uint32_t mesh = 0;
  bool is_sparse = false;
  std::vector<std::byte> indices = {}, start = {}, end = {};
  std::vector<std::byte> transform = {}, start_transform = {};

  MeshPositions view() const { return {mesh, start, end, is_sparse, indices, transform, start_transform}; }
};

/// Borrows the updates' bytes.
inline FrameInput frame_of(const std::vector<OwnedUpdate>& updates) {
  FrameInput input;
  for (const OwnedUpdate& update : updates) input.updates.push_back(update.view());
  return input;
}

inline std::vector<std::byte> bytes_of(const std::vector<uint32_t>& indices) {
  const auto* bytes = reinterpret_cast<const std::byte*>(indices.data());
  return {bytes, bytes + indices.size() * sizeof(uint32_t)};
}

inline uint64_t bytes_in(const std::vector<MeshPositions>& updates) {
  uint64_t sum = 0;
  for (const MeshPositions& u : updates) sum += u.indices.size() + u.start.size() + u.end.size();
  return sum;
}

/// The same updates with their bytes one after another in `memory`, from `offset` on.
inline std::vector<MeshPositions> moved_to(std::span<std::byte> memory, std::vector<MeshPositions> updates,
                                           uint64_t offset = 0) {
  const auto move = [&](std::span<const std::byte>& bytes) {
    if (bytes.empty()) return;
    std::memcpy(memory.data() + offset, bytes.data(), bytes.size());
    bytes = memory.subspan(offset, bytes.size());
    offset += bytes.size();
  };
  for (MeshPositions& u : updates) {
    move(u.indices);
    move(u.start);
    move(u.end);
  }
  return updates;
}

/// A frame of the detector's with the positions sent from a slot's room.
inline FrameInput sent(const std::shared_ptr<FrameSlot>& slot, const std::vector<MeshPositions>& updates) {
  slot->send(moved_to(slot->room(bytes_in(updates)), updates));
  FrameInput input;
  input.slot = slot;
  return input;
}

/// On the backend, and pinned.
inline uint64_t staging_bytes(const Detector& detector) {
  uint64_t sum = 0;
  for (const MemoryPart& part : detector.memory())
    if (part.part == "staging" || part.part == "pinned") sum += part.bytes;
  return sum;
}

}  // namespace collided::test
