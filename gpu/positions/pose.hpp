#pragma once
// Poses of rigid meshes, and where they put vertices. Whoever computes it gets the same bits.

#include <array>

#include "gpu/base/host_device.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

/// p -> R p + t: the rows of [R | t]. R is a rotation, or as near to one as check_pose asks.
struct Pose {
  std::array<double, 12> rows = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  double r(int i, int k) const { return rows[static_cast<size_t>(4 * i + k)]; }
  double t(int i) const { return rows[static_cast<size_t>(4 * i + 3)]; }
  bool has_rotation_of(const Pose& other) const {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        if (r(i, k) != other.r(i, k)) return false;
    return true;
  }
};

/// How far R is from a rotation, by the Frobenius norm of R^T R - I.
double rotation_defect(const Pose& pose);
double determinant(const Pose& pose);

/// Returns sin(angle / 2) times the axis of the rotation from one pose to another.
Vec3<double> half_turn(const Pose& from, const Pose& to);

/// Returns the pose at a fraction of the way from one pose to another. Each vertex is then beside the
/// point at this fraction of its straight way, on its arc about the axis of the screw from pose to pose. It is off the
/// straight way by the sagitta of the arc at most. Both ends are exact. The source has the derivation.
Pose pose_along(const Pose& from, const Pose& to, double fraction);

/// fl(fl(fl(fl(r0 x) + fl(r1 y)) + fl(r2 z)) + t) for each row, every operation rounded to binary64 (none fused), then
/// to the format of the positions.
template <class Real>
COLLIDED_HD Vec3<Real> transformed(const double (&m)[12], const Vec3<Real>& p) {
  const double x = static_cast<double>(p.x), y = static_cast<double>(p.y), z = static_cast<double>(p.z);
  return {static_cast<Real>(((m[0] * x + m[1] * y) + m[2] * z) + m[3]),
          static_cast<Real>(((m[4] * x + m[5] * y) + m[6] * z) + m[7]),
          static_cast<Real>(((m[8] * x + m[9] * y) + m[10] * z) + m[11])};
}

/// The same of all vertices of a mesh.
template <class Real>
struct TransformPositions {
  double rows[12];
  const Vec3<Real>* from;
  Vec3<Real>* to;

  TransformPositions(const Pose& pose, const Vec3<Real>* rest, Vec3<Real>* out) : from(rest), to(out) {
    for (size_t i = 0; i < 12; ++i) rows[i] = pose.rows[i];
  }
  COLLIDED_HD void operator()(uint64_t i) const { to[i] = transformed(rows, from[i]); }
};

}  // namespace collided
