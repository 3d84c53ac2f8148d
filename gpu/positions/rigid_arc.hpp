#pragma once
// A rigid mesh that goes from one pose to another moves along a screw: it turns about an axis, evenly, while it slides
// along it. A step's paths are straight. This bounds the distance between the two, for all vertices and at all times.

#include "gpu/base/box.hpp"
#include "gpu/base/mesh_turns.hpp"
#include "gpu/positions/pose.hpp"

namespace collided {

/// Radians that R turns by from one pose to the other, 0 to pi.
double angle_between(const Pose& from, const Pose& to);

/// Returns a distance that no vertex of a mesh exceeds between its screw and its straight path at the same time. The
/// mesh's positions at rest are in `rest`, and its posed positions are rounded to Real. Returns 0 if R is the same in
/// both poses: straight paths between the posed positions are then the motion itself. The source has the derivation.
template <class Real>
double arc_deviation(const Pose& from, const Pose& to, const Box<double>& rest);

/// Returns how a mesh turns from one pose to the other, with the same bounds.
template <class Real>
MeshTurn mesh_turn(const Pose& from, const Pose& to, const Box<double>& rest);

/// Largest magnitude of a coordinate that a pose can give to positions in `rest`, rounded up.
double largest_coordinate(const Pose& pose, const Box<double>& rest);

}  // namespace collided
