#pragma once
// How two meshes, one of them a solid, lie to each other, in words and as JSON.

#include <span>
#include <string>

#include "client/app/report/json.hpp"
#include "client/cpp/client.hpp"
#include "client/cpp/scene_features.hpp"

namespace collided::cli {

/// A frame of DCD, and how its meshes are named. All are borrowed.
struct PairPlace {
  std::span<const client::MeshInput> meshes;
  const client::SceneFeatures& scene;
  const client::FrameOutput& output;
};

/// Returns "ball and box touch", "ball and box overlap" or "ball is inside box".
std::string state_text(const client::MeshPair& pair, const PairPlace& place);

/// Returns a line on the vertices of each mesh that are inside the other, and on the deepest of them; "" if there is
/// none. The way out is known if the frame has vertex-solid contacts with normals.
std::string inside_text(const client::MeshPair& pair, const PairPlace& place);

/// `state`; `inside_count`, of vertices of the first and of the second mesh that are inside the other one; and
/// `deepest` of them: its mesh, its number there, `depth` and `direction`, the unit vector of its way out. Each is null
/// if there is none.
Json state_json(const client::MeshPair& pair, const PairPlace& place);

}  // namespace collided::cli
