#pragma once
// How rigid meshes turn in a step, or in the part of it that they go. A mesh moves along the screw between two poses.

#include "gpu/base/deviations.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

/// Of one mesh. Lengths are bounds of all of its vertices, in the unit of the positions. What positions lose when they
/// are rounded to the scene's format counts in `rounded` alone.
struct MeshTurn {
  double deviation = 0;       ///< between screw and straight way; 0: the mesh does not turn
  double rounding = 0;        ///< the part of it that rounding of poses and what R is off a rotation explain
  double rounded = 0;         ///< how far positions at either end may be from the screw
  double bend = 0;            ///< an arc is off its chord by no more than this times the chord's length
  double defect = 0;          ///< how far both R may be from the rotations that they stand for
  Vec3<double> half_turn{};   ///< sin(angle / 2) times the axis
  Vec3<double> back[3] = {};  ///< rows of the rotation from the end to the start

  COLLIDED_HD bool turns() const { return deviation > 0; }
  COLLIDED_HD Vec3<double> turned_back(const Vec3<double>& v) const {
    return {dot(back[0], v), dot(back[1], v), dot(back[2], v)};
  }
};

/// By mesh. None where no mesh can turn.
struct MeshTurns {
  const uint32_t* first_vertex = nullptr;  ///< of each mesh
  const MeshTurn* of_mesh = nullptr;
  uint32_t meshes = 0;

  /// Null of a mesh that does not turn, which it is enough to name a vertex of.
  COLLIDED_HD const MeshTurn* of(uint32_t vertex) const {
    if (meshes == 0) return nullptr;
    const MeshTurn* turn = of_mesh + mesh_at(first_vertex, meshes, vertex);
    return turn->turns() ? turn : nullptr;
  }
};

/// How the meshes of a pair's features turn; null: not at all.
struct PairTurn {
  const MeshTurn* first = nullptr;
  const MeshTurn* second = nullptr;

  COLLIDED_HD bool is_straight() const { return first == nullptr && second == nullptr; }
  COLLIDED_HD bool both() const { return first != nullptr && second != nullptr; }
};

}  // namespace collided
