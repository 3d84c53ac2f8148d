#pragma once
// What an edit makes of a scene's meshes, on the host.

#include <vector>

#include "gpu/positions/checks.hpp"
#include "gpu/types.hpp"

namespace collided {

struct EditedScene {
  SceneSpec spec;                    ///< with the elements of all meshes, where features change
  bool changes_features = false;     ///< meshes come or go, or have other elements
  FirstMeshes first;                 ///< meshes that have their first positions in the edit's frame
  std::vector<bool> new_solids;      ///< solids whose volumes have to be looked at in that frame
  std::vector<bool> begins_at_rest;  ///< meshes whose rest pairs, if they exclude any, are those of that frame
};

/// `spec`, `topology`: of the scene before. `frame` has an edit; in CCD (`is_ccd`) it has to say where the vertices of
/// a mesh begin that gets another number of them. Throws InvalidInput, naming what cannot be had.
EditedScene edit_scene(const SceneSpec& spec, const Topology& topology, const FrameInput& frame, bool is_ccd);

}  // namespace collided
