#pragma once
// Numbers of the protocol that daemon and clients must agree on.

#include <cstddef>
#include <cstdint>

namespace collided::v1 {

/// Window of a stream whose client requests none.
inline constexpr uint32_t kDefaultWindow = 2;

/// Largest message that the daemon sends over gRPC: gRPC's own default limit of a received one.
inline constexpr size_t kMaxAnswerBytes = size_t{4} << 20;

// The local socket (collided/v1/local.proto).

inline constexpr uint32_t kLocalVersion = 1;
inline constexpr size_t kMaxPacketBytes = size_t{64} << 10;
/// Sizes of shared-memory regions are multiples of it.
inline constexpr uint64_t kPageBytes = 4096;
/// Offsets of shared ranges are multiples of it.
inline constexpr uint64_t kRangeAlignment = 8;
inline constexpr uint64_t kMaxOutputBytes = uint64_t{1} << 30;
inline constexpr size_t kCudaIpcHandleBytes = 64;
/// Of each mesh: its update's message, and the alignment of its arrays.
inline constexpr uint64_t kUpdateBytes = 256;

/// Beside what frames can have: for edits, and for positions of what they add.
inline constexpr uint64_t kMaxEditInputBytes = uint64_t{256} << 20;

constexpr uint64_t whole_pages(uint64_t bytes) { return (bytes + kPageBytes - 1) / kPageBytes * kPageBytes; }

/// Largest message of a frame whose arrays are in shared memory.
constexpr uint64_t max_frame_message_bytes(uint64_t meshes) { return kMaxPacketBytes + meshes * kUpdateBytes; }

/// Maximum input region of one frame: positions (`vertex_bytes` for each vertex), an index for each vertex, and its
/// message where it has many meshes.
constexpr uint64_t max_frame_input_bytes(uint64_t vertices, uint64_t vertex_bytes, uint64_t meshes) {
  return whole_pages(vertices * (vertex_bytes + sizeof(uint32_t)) + max_frame_message_bytes(meshes));
}

}  // namespace collided::v1
