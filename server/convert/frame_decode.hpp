#pragma once
// A request of the frame stream from the wire: its positions go straight to where the backend reads them, the rest is
// parsed by the generated code.

#include <google/protobuf/io/zero_copy_stream.h>

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "collided/v1/collision_service.pb.h"
#include "server/convert/convert.hpp"

namespace collided::server {

struct DecodedRequest {
  pb::StreamFramesRequest message;
  std::vector<PlacedPositions> placed;  ///< one for each update of the frame
};

/// `bytes`: of the whole message. `room` is asked once, before the first positions are read, for memory to put them in;
/// what does not fit stays in the message. Throws InvalidInput for bytes that are no message.
DecodedRequest decode_request(google::protobuf::io::ZeroCopyInputStream& wire, size_t bytes,
                              const std::function<std::span<std::byte>()>& room);

}  // namespace collided::server
