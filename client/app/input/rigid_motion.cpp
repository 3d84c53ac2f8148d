// The motion of meshes that move as rigid bodies, found from their positions.

#include "client/app/input/rigid_motion.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "client/scenes/vec3.hpp"

namespace collided::cli {

namespace {

using scenes::cross, scenes::dot, scenes::length, scenes::minus, scenes::unit, scenes::Vec3d;

constexpr double kTolerance = 1e-6;  // of the mesh's extent, by which a vertex may miss the pose

/// Vertices that span the mesh: the first, the farthest from it, and the farthest from the line through both.
struct Corners {
  size_t a = 0, b = 0, c = 0;
  double extent = 0;  ///< from a to b
};

Corners corners_of(const std::string& mesh, client::Positions positions) {
  Corners out;
  const auto farthest = [&](const auto& distance) {
    size_t best = 0;
    for (size_t i = 1; i < positions.size(); ++i)
      if (distance(positions[i]) > distance(positions[best])) best = i;
    return best;
  };
  out.b = farthest([&](const Vec3d& p) { return length(minus(p, positions[0])); });
  const Vec3d line = minus(positions[out.b], positions[0]);
  out.c = farthest([&](const Vec3d& p) { return length(cross(line, minus(p, positions[0]))); });
  out.extent = length(line);
  if (!(length(cross(line, minus(positions[out.c], positions[0]))) > kTolerance * out.extent * out.extent))
    throw std::runtime_error("mesh " + mesh + " is a point or a line, which has no pose");
  return out;
}

/// An orthonormal frame at three positions.
std::array<Vec3d, 3> axes_at(client::Positions positions, const Corners& at) {
  const Vec3d x = unit(minus(positions[at.b], positions[at.a]));
  const Vec3d z = unit(cross(x, minus(positions[at.c], positions[at.a])));
  return {x, cross(z, x), z};
}

}  // namespace

client::RigidMatrix pose_of(const std::string& mesh, client::Positions first, client::Positions now) {
  const Corners corners = corners_of(mesh, first);
  const auto from = axes_at(first, corners), to = axes_at(now, corners);
  client::RigidMatrix pose{};
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 3; ++column)
      for (size_t axis = 0; axis < 3; ++axis) pose[4 * row + column] += to[axis][row] * from[axis][column];
    const Vec3d rotation{pose[4 * row], pose[4 * row + 1], pose[4 * row + 2]};
    pose[4 * row + 3] = now[corners.a][row] - dot(rotation, first[corners.a]);
  }
  std::vector<double> moved;
  for (const Vec3d& p : first) moved.insert(moved.end(), p.begin(), p.end());
  client::move_rigidly(std::span<double>(moved), pose);
  for (size_t i = 0; i < now.size(); ++i)
    if (!(length(minus(now[i], {moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]})) <= kTolerance * corners.extent))
      throw std::runtime_error("mesh " + mesh + " does not move as a rigid body: no pose puts its vertex " +
                               std::to_string(i) + " where it is");
  return pose;
}

RigidMotion::RigidMotion(const std::vector<scenes::Mesh>& meshes, std::vector<uint32_t> rigid)
    : meshes_(meshes), rigid_(std::move(rigid)) {}

client::Positions RigidMotion::part_of(const std::vector<Vec3d>& positions, uint32_t mesh) const {
  size_t begin = 0;
  for (uint32_t i = 0; i < mesh; ++i) begin += meshes_[i].vertex_count;
  return client::Positions(positions).subspan(begin, meshes_[mesh].vertex_count);
}

void RigidMotion::apply_to(v1::Frame& frame, std::vector<Vec3d> positions) {
  if (first_.empty()) {
    first_ = std::move(positions);
    return;
  }
  for (v1::MeshUpdate& update : *frame.mutable_updates()) {
    const uint32_t mesh = update.mesh();
    if (std::find(rigid_.begin(), rigid_.end(), mesh) == rigid_.end()) continue;
    update = client::rigid_update(mesh, pose_of(meshes_[mesh].name, part_of(first_, mesh), part_of(positions, mesh)));
  }
}

}  // namespace collided::cli
