#pragma once
// What collidectl view sends to its page: binary WebSocket messages, little-endian.
//
//   uint32   kind (MessageKind)
//   uint32   bytes of the JSON that follows, a multiple of 4
//   JSON     one object, padded with spaces; its "arrays" gives the number of 4-byte values of each array
//   arrays   those of "arrays", in that order, one after the other
//
// kScene, once, and again whenever the scene is edited or the daemon was lost:
//   epoch            of the frames that belong to it
//   scene_id, name
//   scene            as `collidectl info` shows scenes
//   meshes           [{name, motion, first, vertices, triangles}]: `first` and `vertices` as they are shown
//   vertex_stride    one of so many vertices is shown; 1: all
//   triangles        uint32[n][3], corners that are shown vertices, mesh after mesh
//   edges            uint32[n][2], loose edges
//   points           uint32[n], loose points
// kFrame, the latest; the page is sent the next one when it asks for it, with the text "next":
//   epoch, frame, skipped_frames, omitted_contacts, origin (of the positions, double[3]) and the frame's cost and
//   contacts, as `collidectl watch --json` shows them
//   positions        float32[n][3] of the shown vertices, relative to `origin`
//   vertex_triangle  uint32[n][4]: the vertex and the triangle's corners
//   edge_edge        uint32[n][4]: both ends of each edge
//   triangle_triangle uint32[n][6]: the corners of both
//   edge_triangle    uint32[n][5]: both ends of the edge, the corners of the triangle that it goes through
// kStatus: state ("live", "waiting" or "ended"), message (why; may be empty)

#include <cstdint>
#include <string>

#include "client/app/report/json.hpp"
#include "client/cli/web/surface.hpp"
#include "client/cpp/watcher.hpp"

namespace collided::cli {

enum class MessageKind : uint32_t { kScene = 1, kFrame = 2, kStatus = 3 };

/// The only message that the page sends: it has shown a frame, and takes another one.
constexpr const char* kNextFrame = "next";

/// A scene as the page knows it.
struct ShownScene {
  uint32_t epoch = 0;
  v1::Scene scene;
  Surface surface;
  std::array<double, 3> origin{};
  bool has_origin = false;  ///< the first frame has it
};

std::string scene_message(const ShownScene& shown);
/// The first frame of a scene sets its origin, the middle of the positions. Throws Error (DATA_LOSS) for positions that
/// do not fit the scene.
std::string frame_message(ShownScene& shown, const client::WatchedFrame& frame);
/// `state`: "live", "waiting" or "ended".
std::string status_message(const std::string& state, const std::string& message);

}  // namespace collided::cli
