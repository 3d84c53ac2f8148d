#pragma once
// A test case: meshes and their vertex positions at t = 0 and t = 1.

#include <ostream>
#include <string>
#include <vector>

#include "client/scenes/scene.hpp"
#include "gpu/detector.hpp"

namespace collided::test {

using Vec3d = std::array<double, 3>;
using Positions = std::vector<Vec3d>;

struct Case {
  std::string name;
  std::vector<MeshSpec> meshes;
  std::vector<Positions> start;  ///< of each mesh, t = 0
  std::vector<Positions> end;    ///< t = 1; static meshes: the same as start
};

// GoogleTest prints parameter values with it.
inline void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

/// A frame that owns its bytes; input() borrows them.
class Frame {
 public:
  Frame(const Case& c, Mode mode, Scalar scalar, bool with_static = true);
  FrameInput input() const;

 private:
  struct Update {
    uint32_t mesh;
    std::vector<std::byte> start, end;
  };
  std::vector<Update> updates_;
};

std::vector<std::byte> pack(const Positions& positions, Scalar scalar);
/// To the nearest of the box's 65535 steps (Q16); positions outside go to its sides.
std::vector<std::byte> encoded(const Positions& positions, const PositionBox& box);

/// The case with every coordinate rounded to what the scalar type holds.
Case rounded(Case c, Scalar scalar);

/// The procedural scene between two times.
Case case_of(const scenes::Scene& scene, double t0, double t1);
Case case_of(const std::string& scene, double t, Mode mode);

/// Names of all procedural scenes, to run a test on each.
std::vector<std::string> scene_names();

/// Whether there is a procedural scene, or a variant of one, of that name.
bool is_procedural(const std::string& name);

/// Thickness for discrete tests of a scene: scenes of mixed scale have triangles far smaller than the others'.
inline double dcd_thickness(const std::string& scene) {
  return scene.starts_with("multiscale_knots") || scene == "graded_sheets" ? 5e-4 : 0.01;
}

/// Adds a mesh that moves from `start` to `end`; an empty `end` means that it stands still.
void add_mesh(Case& c, std::vector<std::array<uint32_t, 3>> triangles, Positions start, Positions end = {},
              bool is_static = false);

/// `settings` with the case's meshes.
SceneSpec spec_for(const Case& c, SceneSpec settings);

/// Creates a scene for the case and runs its one frame.
FrameResult run_case(const Case& c, const SceneSpec& settings);

}  // namespace collided::test
