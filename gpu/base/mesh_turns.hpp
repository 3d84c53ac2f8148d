#pragma once
// Says how rigid meshes turn on their ways. A mesh moves along the screw from its pose at the start to that at the end.

#include "gpu/base/deviations.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

/// Holds how one mesh turns. Lengths are in the unit of the positions, and no vertex exceeds them. Only `rounded`
/// counts what positions lose when they are rounded to the scene's format.
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

/// Holds the turns of all meshes of a scene; of none where no mesh can turn.
struct MeshTurns {
  const uint32_t* first_vertex = nullptr;  ///< of each mesh
  const MeshTurn* of_mesh = nullptr;
  uint32_t meshes = 0;

  /// Returns how the mesh of a vertex turns; null: it does not.
  COLLIDED_HD const MeshTurn* of(uint32_t vertex) const {
    if (meshes == 0) return nullptr;
    const MeshTurn* turn = of_mesh + mesh_at(first_vertex, meshes, vertex);
    return turn->turns() ? turn : nullptr;
  }
};

/// Holds how the meshes of both features of a pair turn; null: not at all.
struct PairTurn {
  const MeshTurn* first = nullptr;
  const MeshTurn* second = nullptr;

  COLLIDED_HD bool is_straight() const { return first == nullptr && second == nullptr; }
  COLLIDED_HD bool both() const { return first != nullptr && second != nullptr; }
};

}  // namespace collided
