#pragma once
// Procedural scenes: deterministic meshes whose vertices move by a formula of the time t in [0, 1].

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace collided::scenes {

using Vec3d = std::array<double, 3>;

struct Mesh {
  std::string name;
  uint32_t vertex_count = 0;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< vertices counted from 0 in the mesh
  bool is_static = false;
  std::vector<std::array<uint32_t, 2>> edges = {};  ///< loose ones
  std::vector<uint32_t> points = {};                ///< loose ones
};

/// A scene that can be asked for its positions at any time.
class Scene {
 public:
  virtual ~Scene() = default;
  virtual const std::vector<Mesh>& meshes() const = 0;
  /// Positions of every vertex of every mesh, in mesh order, at time t in [0, 1].
  virtual std::vector<Vec3d> positions(double t) const = 0;
  uint64_t triangle_count() const {
    uint64_t n = 0;
    for (const Mesh& m : meshes()) n += m.triangles.size();
    return n;
  }
};

struct SceneInfo {
  std::string name;
  std::string description;  ///< one line, for `collidectl scenes`
};

/// The scenes that make_scene knows, in the order of the documentation.
std::vector<SceneInfo> list_scenes();

/// Scenes that make_scene also knows, but that differ from one of list_scenes in a single number. They are listed apart
/// so that going through all scenes does not repeat nearly the same work.
std::vector<SceneInfo> list_variants();

/// Throws std::invalid_argument naming the known scenes, or the limits of `scale`.
void check_scene(const std::string& name, double scale);
/// Throws what check_scene throws. `scale` refines the grids: the number of triangles grows with about scale^2.
/// cloth_ball has 1 M triangles at 3.302 (a cloth of 700 x 700 quads) and 9.9 M at 10.377 (2200 x 2200), nbody 1 M at
/// 2.57. Refining keeps the same bodies on the same paths, so that sizes can be compared.
std::unique_ptr<Scene> make_scene(const std::string& name, double scale = 1.0);

}  // namespace collided::scenes
