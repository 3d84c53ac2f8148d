#pragma once
// The contacts of one kind of one frame, put together from the daemon's chunks.

#include <array>
#include <cstdint>
#include <vector>

#include "collided/v1/contact.pb.h"

namespace collided::client {

class FrameTransport;

/// One entry a contact in every array; an array that was not asked for or not computed is empty.
struct Contacts {
  uint64_t count = 0;
  std::vector<std::array<uint32_t, 2>> elements;
  std::vector<std::array<uint32_t, 4>> stencils;
  std::vector<double> toi;
  std::vector<double> distance;
  std::vector<std::array<double, 2>> weights;
  std::vector<uint8_t> flags;
};

/// Adds a chunk; arrays in shared memory are read through the transport that brought it. Throws Error (DATA_LOSS) if
/// one of its arrays has not `count` entries.
void append(Contacts& contacts, const v1::ContactChunk& chunk, const FrameTransport& transport);

}  // namespace collided::client
