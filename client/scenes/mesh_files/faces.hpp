#pragma once
// What all formats share once a file is parsed: indices are checked, repeated corners dropped, faces split.

#include <string>

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

/// Makes a mesh of triangles. Faces that equal those of `like` are split as they were split there.
MeshFile split_faces(RawMesh raw, const std::string& file, const MeshFile* like);

}  // namespace collided::scenes
