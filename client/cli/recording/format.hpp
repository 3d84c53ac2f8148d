#pragma once
// Recordings: the frames of a stream in a file, to be played again.
//
// A recording is the line "collided recording 1", then messages of the protocol, each after its length in bytes as a
// varint: the SceneSpec, whole, with the triangles, edges and points of its meshes, then every Frame. A length of 0
// ends it, so that a file that was cut off is never taken for a shorter one.

#include <cstdint>
#include <string_view>

namespace collided::cli {

constexpr std::string_view kRecordingTitle = "collided recording ", kRecordingHeader = "collided recording 1\n";
constexpr uint64_t kMaxRecordedBytes = INT32_MAX;  ///< of a message, as protobuf takes them

}  // namespace collided::cli
