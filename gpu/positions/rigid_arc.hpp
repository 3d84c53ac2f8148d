#pragma once
// A rigid mesh that goes from one pose to another moves along a screw: it turns about an axis, evenly, while it moves
// along it. A step's paths are straight. How far the one is from the other, for all vertices and at all times.

#include "gpu/base/box.hpp"
#include "gpu/positions/pose.hpp"

namespace collided {

/// Radians that R turns by from one pose to the other, 0 to pi.
double angle_between(const Pose& from, const Pose& to);

/// What no vertex of a mesh whose positions at rest are in `rest` is farther from its straight path at any time than;
/// 0 where the mesh does not turn. A vertex at distance r of the axis runs along an arc of angle a, which is r a^2 / 8
/// from its chord at the most, for that bounds the error of linear interpolation by the second derivative. What R lacks
/// to be a rotation is added, and so are the roundings of positions to numbers of relative error `unit`.
double arc_deviation(const Pose& from, const Pose& to, const Box<double>& rest, double unit);

/// Largest magnitude of a coordinate that a pose can give to positions in `rest`, rounded up.
double largest_coordinate(const Pose& pose, const Box<double>& rest);

}  // namespace collided
