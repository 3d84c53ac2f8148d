// What is said of solids in types.hpp and contact_set.hpp, and does not hold: minimal cases that the judge has found.

#include <cmath>

#include "tests/gpu/solids/judged_solids.hpp"

namespace collided::test {
namespace {

class SolidsRefuted : public OnBackend<> {
 protected:
  static SolidsScene scene_of(std::initializer_list<Shape> shapes) {
    SolidsScene scene;
    for (const Shape& shape : shapes) add_solid(scene, {shape, {}});
    return scene;
  }
  static FrameResult states_of(const SolidsScene& scene) {
    return run_solids(scene, looking_into_solids(Accuracy::kExact, Scalar::kF64));
  }
  static SceneSpec looking_for_signs() {
    SceneSpec spec = settings(Mode::kDcd, Accuracy::kExact, Scalar::kF64, 1);
    spec.fields = spec.fields.with(ContactField::kSignedDistance);
    return spec;
  }
  /// Signs of all contacts at a distance.
  static std::vector<double> signs_at(const ContactSet& set, double distance) {
    std::vector<double> signs;
    for (size_t i = 0; i < set.size(); ++i)
      if (std::abs(set.distance[i] - distance) < 1e-9) signs.push_back(set.signed_distance[i]);
    return signs;
  }
};

/// A point on a face is a point in common.
TEST_F(SolidsRefuted, ALoosePointOnAFaceTouches) {
  SolidsScene scene = scene_of({unit_cube()});
  MeshSpec point;
  point.vertex_count = 1, point.points = {0};
  add_surface(scene, point, {{0.5, 0.25, 1}});
  const FrameResult r = states_of(scene);
  ASSERT_EQ(r.pair_states.size(), 1u);
  EXPECT_EQ(r.pair_states[0].state, PairState::kTouching);
}

/// The first parts of both are one cube; where the others are, one of them is inside out and larger.
TEST_F(SolidsRefuted, VolumesThatCancel) {
  const Shape cube = unit_cube(), larger = box({4, 0, 0}, {6, 1, 1});
  const SolidsScene scene =
      scene_of({together(together(cube, box({10, 0, 0}, {20, 1, 1})), reversed(larger)), together(cube, larger)});
  const FrameResult r = states_of(scene);
  ASSERT_EQ(r.pair_states.size(), 1u);
  EXPECT_EQ(r.pair_states[0].state, PairState::kOverlapping);
}

/// The face of a tetrahedron inscribed in a cube is inside the cube, though its corners are on it.
TEST_F(SolidsRefuted, SignInsideBetweenCornersThatTouch) {
  const FrameResult r = run_solids(scene_of({unit_cube(), inscribed(false)}), looking_for_signs());
  const std::vector<double> signs = signs_at(r.vertex_triangle, std::sqrt(1 / 3.0));  // of corner 1 1 1
  ASSERT_FALSE(signs.empty());
  for (const double sign : signs) EXPECT_LT(sign, 0);
}

/// A triangle in the plane of a cube's diagonals divides it, and its border is far outside.
TEST_F(SolidsRefuted, NoSignWhereAllCrossingsAreTies) {
  SolidsScene scene = scene_of({unit_cube()});
  MeshSpec sheet;
  sheet.vertex_count = 3, sheet.triangles = {{0, 1, 2}};
  add_surface(scene, sheet, {{-9, 10, -9}, {10, -9, -9}, {0.5, 0.5, 20}});
  const FrameResult r = run_solids(scene, looking_for_signs());
  const std::vector<double> signs = signs_at(r.vertex_triangle, std::sqrt(0.5));
  ASSERT_FALSE(signs.empty());
  for (const double sign : signs) EXPECT_TRUE(std::isnan(sign)) << sign;
}

}  // namespace
}  // namespace collided::test
