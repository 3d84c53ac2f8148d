#pragma once
// The contacts of one kind of one frame, assembled from the daemon's chunks.

#include <array>
#include <cstdint>
#include <vector>

#include "collided/v1/contact.pb.h"

namespace collided::client {

class FrameTransport;

/// Each array has one entry per contact, or is empty if it was not requested or not computed.
struct Contacts {
  uint64_t count = 0;
  std::vector<std::array<uint32_t, 2>> elements;
  std::vector<std::array<uint32_t, 4>> stencils;
  std::vector<double> toi;
  std::vector<double> distance;
  std::vector<std::array<double, 2>> weights;
  std::vector<uint8_t> flags;
};

/// Appends a chunk; arrays in shared memory are read through `transport`. Throws Error (DATA_LOSS) if
/// the length of an array is not the chunk's `count`.
void append(Contacts& contacts, const v1::ContactChunk& chunk, const FrameTransport& transport);

}  // namespace collided::client
