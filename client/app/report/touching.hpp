#pragma once
// Says in sentences which meshes touch.

#include <span>
#include <string>
#include <vector>

#include "client/app/report/json.hpp"
#include "client/cpp/client.hpp"
#include "client/cpp/scene_features.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// Meshes that stand still, and the contacts between them.
struct Touching {
  std::span<const client::MeshInput> meshes;
  std::span<const scenes::Vec3d> positions;  ///< of all meshes
  const client::FrameOutput& output;         ///< with all fields
  const v1::SceneSpec& spec;
  const client::SceneFeatures& scene;
};

/// Returns the pairs of meshes that touch, each with their names and the number of contacts, and how they lie to each
/// other if one is a solid. If the spec asks for edge-triangle contacts, a pair also has how many edges go through
/// triangles, how many pairs of features touch, and the first of these crossings. Empty if the spec asks for no
/// contacts.
Json touching_json(const Touching& touching);

/// A sentence for each pair that touches, or one that says that none does.
std::string touching_text(const Touching& touching);

/// The same of a mesh that moves from one frame to the next.
std::string step_text(const std::string& name, const Touching& touching);

}  // namespace collided::cli
