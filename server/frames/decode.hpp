#pragma once
// Decodes a request of the frame stream: positions go straight to where the backend reads them, the other fields are
// parsed by the generated code.

#include <google/protobuf/io/zero_copy_stream.h>

#include <cstddef>
#include <exception>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collided/v1/collision_service.pb.h"
#include "server/convert/frame.hpp"

namespace collided::server {

struct DecodedRequest {
  pb::StreamFramesRequest message;
  std::vector<PlacedPositions> placed;  ///< one for each update of the frame
  std::exception_ptr refusal;           ///< of a frame that was not read to its end; else null
};

/// What a stream may send at this point.
struct Expected {
  /// Of the scene; a frame with more updates is refused. None: the stream is not open yet, and only `open` is read.
  std::optional<size_t> meshes;
  size_t worlds = 0;  ///< of a set: a frame may name them all
};

/// `bytes`: of the whole message. `room` is called once, before the first positions are read, for memory to put them
/// in; positions that do not fit stay in the message. Whatever the message holds, memory and work are proportional to
/// the scene's meshes and to the positions. Throws InvalidInput for malformed bytes, LimitExceeded for too many fields,
/// FailedPrecondition for a message that is not expected.
DecodedRequest decode_request(google::protobuf::io::ZeroCopyInputStream& wire, size_t bytes, const Expected& expected,
                              const std::function<std::span<std::byte>()>& room);

/// Throws InvalidInput for more updates than a scene of so many meshes can have. `path` names the frame.
void check_update_count(const pb::Frame& frame, size_t meshes, const char* path);

/// Parses a whole frame for a scene of so many meshes and, if it is a set, worlds. `path` names it in refusals.
/// Throws InvalidInput, LimitExceeded.
pb::Frame parse_bounded_frame(const std::string& bytes, size_t meshes, size_t worlds, const char* path);

}  // namespace collided::server
