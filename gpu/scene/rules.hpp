#pragma once
// Which options go together: the one place of these rules.

#include <string>
#include <vector>

#include "gpu/state/settings.hpp"

namespace collided {

/// Throws InvalidInput for a thickness, delta or min_separation that is negative or not finite, for kinds all off,
/// triangle pairs in CCD, and reports that the mode or the accuracy does not have. Reads no mesh.
void check_spec(const SceneSpec& spec);

/// Throws InvalidInput for rings above the limit, pairs of meshes that the scene does not have or that are named twice,
/// a rest_distance that no mesh uses, rest pairs of a scene without contacts of features, half thicknesses that are no
/// lengths, and what check_distances() refuses with the scene's own options.
void check_exclusions(const SceneSpec& spec);

/// Those of its own that a mesh of the scene has, which `field` names.
void check_mesh(const SceneSpec& spec, const MeshSpec& mesh, const std::string& field);
/// Throws InvalidInput if features are tested in DCD at kFast, and two meshes touch within a distance of 0.
void check_distances(const SceneSpec& spec, const FrameSettings& settings);
/// Throws InvalidInput for a rest_distance that is no length.
void check_rest_distance(const SceneSpec& spec);

/// Options of the scene that are set, and that this frame has no use for, though another one might.
std::vector<std::string> unused_options(const SceneSpec& spec, const FrameInput& frame);

/// Throws InvalidInput naming the frame's option that the scene cannot have. A frame with an edit has yet to pass
/// check_distances() for the edited scene.
void check_frame(const SceneSpec& spec, const FrameInput& frame);

}  // namespace collided
