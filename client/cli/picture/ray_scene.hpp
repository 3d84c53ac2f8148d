#pragma once
// Triangles, balls and tubes that rays meet: a scene of Embree.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "client/cli/picture/embree.hpp"
#include "client/scenes/vec3.hpp"

namespace collided::cli {

/// With round ends, which are not the same.
struct Tube {
  scenes::Vec3d a, b;
};

struct RayHit {
  double distance = 0;
  scenes::Vec3d normal;    ///< unit, towards where the ray came from
  uint32_t part = 0;       ///< the number that it was added with
  uint32_t primitive = 0;  ///< of the part
  double u = 0, v = 0;     ///< of a triangle: weights of its second and third corner
};

/// Filled, then committed, then asked, by any number of threads. Throws std::runtime_error if memory runs out.
class RayScene {
 public:
  RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;
  ~RayScene();

  /// Each adds a part, unless it is empty; `part` is a number that no other one has.
  void add_triangles(uint32_t part, std::span<const scenes::Vec3d> positions,
                     std::span<const std::array<uint32_t, 3>> triangles);
  void add_balls(uint32_t part, std::span<const scenes::Vec3d> centres, double radius);
  void add_tubes(uint32_t part, std::span<const Tube> tubes, double radius);
  void commit();

  /// The first thing that a ray meets; `direction` is of unit length.
  std::optional<RayHit> first_hit(const scenes::Vec3d& origin, const scenes::Vec3d& direction) const;
  /// Whether a ray meets anything within a distance.
  bool is_blocked(const scenes::Vec3d& origin, const scenes::Vec3d& direction, double distance) const;

 private:
  void attach(RTCGeometry geometry, uint32_t part);
  void check() const;

  RTCDevice device_;
  RTCScene scene_;
};

}  // namespace collided::cli
