#pragma once
// A frame as the bytes of a StreamFramesRequest, without a copy of its positions.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "client/cpp/transport/frame_transport.hpp"

namespace collided::client {

/// A piece of a message: its own bytes, then borrowed ones.
struct WirePart {
  std::string head;
  std::span<const std::byte> borrowed;
};

/// The concatenated parts are the request in wire format: `frame` with `updates` after its own. They borrow the large
/// arrays of both.
std::vector<WirePart> encode_frame(const v1::Frame& frame, std::span<const FrameUpdate> updates);

/// Bytes of all parts.
size_t size_of(std::span<const WirePart> parts);

}  // namespace collided::client
