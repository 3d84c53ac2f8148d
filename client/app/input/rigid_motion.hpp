#pragma once
// The motion of meshes that move as rigid bodies, found from their positions.

#include <string>
#include <vector>

#include "client/cpp/client.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// The pose that moves `first` to `now`, three or more positions that are not all on a line. Throws std::runtime_error
/// that names the mesh if no rigid motion does.
client::RigidMatrix pose_of(const std::string& mesh, client::Positions first, client::Positions now);

/// Frames whose rigid meshes send poses after the first.
class RigidMotion {
 public:
  /// Their places in `meshes`, which must outlive it.
  RigidMotion(const std::vector<scenes::Mesh>& meshes, std::vector<uint32_t> rigid);

  /// Replaces the positions of the rigid meshes in a frame with poses; the first frame tells what they start from.
  /// `positions`: of all meshes.
  void apply_to(v1::Frame& frame, std::vector<scenes::Vec3d> positions);

 private:
  client::Positions part_of(const std::vector<scenes::Vec3d>& positions, uint32_t mesh) const;

  const std::vector<scenes::Mesh>& meshes_;
  const std::vector<uint32_t> rigid_;
  std::vector<scenes::Vec3d> first_;
};

}  // namespace collided::cli
