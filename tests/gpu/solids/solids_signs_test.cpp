// Distances with a sign against the judge: which closest points are in the other solid, and which features have a point
// in common with the other's mesh.

#include <cmath>
#include <iostream>

#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/solids/judged_solids.hpp"

namespace collided::test {
namespace {

constexpr std::array kLevels = {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact};

SceneSpec looking_for_signs(Accuracy accuracy, Scalar scalar) {
  SceneSpec spec = settings(Mode::kDcd, accuracy, scalar);
  spec.thickness = 0.75;
  spec.fields = spec.fields.with(ContactField::kNormals).with(ContactField::kSignedDistance);
  return spec;
}

struct SignTally {
  uint64_t inside = 0, outside = 0, meeting = 0, touching = 0, of_no_solid = 0;

  void print(const char* of) const {
    std::cout << of << ": inside " << inside << ", outside " << outside << ", without a sign " << meeting
              << ", at distance 0 " << touching << ", of no solid or of one mesh " << of_no_solid << "\n";
  }
  void expect_all() const {
    for (const uint64_t count : {inside, outside, meeting, touching, of_no_solid}) EXPECT_GT(count, 0u);
  }
};

/// With the distance it leads from the second feature's closest point to the first one's.
bool leads_apart(const ContactSet& set, size_t i, const JudgedSign& judged) {
  const Normal& n = set.normals[i];
  const auto& d = judged.apart;
  const long double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  if (length == 0) return true;
  const long double along = (n[0] * d[0] + n[1] * d[1] + n[2] * d[2]) / length;
  return (set.signed_distance[i] < 0 ? -along : along) > 1 - 0x1p-18L;
}

class SignsJudged : public OnBackend<> {
 protected:
  /// Two bodies in each slot: solids, or sheets, or no bodies (of triangles, an edge or a point), and some that have
  /// contacts with themselves.
  static SolidsScene random_pairs(uint32_t seed, int slots) {
    RandomBodies random(seed);
    SolidsScene scene;
    for (int i = 0; i < slots; ++i) {
      const Vec3d at{8.0 * (i % 8), 8.0 * (i / 8), 0};
      for (int k = 0; k < 2; ++k) {
        const int kind = random.below(8);
        if (kind == 0) {
          Positions positions;
          MeshSpec loose = random.loose(3, positions);
          if (!loose.triangles.empty()) loose.edges.clear();
          if (!loose.points.empty()) loose.points.resize(1);
          for (Vec3d& p : positions) p = {p[0] + at[0], p[1] + at[1], p[2]};
          add_surface(scene, loose, positions);
          continue;
        }
        Body body = moved(random.shuffled(kind == 1 ? random.any(3) : random.convex(3)), at);
        if (k == random.below(4)) body.pieces = {};
        add_solid(scene, body);
        scene.c.meshes.back().solid = !body.pieces.within.empty();
        scene.c.meshes.back().self_contacts = kind == 2;
      }
    }
    return scene;
  }
  /// Compares the signs of all contacts.
  template <class Judged>
  static void expect_signs(const JudgedScene& scene, const ContactSet& set, const Judged& judged_of, SignTally& tally) {
    for (size_t i = 0; i < set.size(); ++i) {
      const auto& ids = set.elements[i];
      const JudgedSign judged = judged_of(ids);
      const double distance = set.distance[i];
      const bool has_sign = judged.has_solid && (distance == 0 || !judged.meets);
      ASSERT_TRUE(std::isnan(set.signed_distance[i]) == !has_sign &&
                  (!has_sign || set.signed_distance[i] == (distance == 0 ? 0 : judged.sign * distance)))
          << ids[0] << " " << ids[1] << " distance " << distance << " signed " << set.signed_distance[i] << ", judged "
          << judged.has_solid << judged.meets << " " << judged.sign
          << scene.text_of({judged.meshes[0], judged.meshes[1]});
      ASSERT_TRUE(leads_apart(set, i, judged)) << ids[0] << " " << ids[1];
      ++(!judged.has_solid ? tally.of_no_solid
         : distance == 0   ? tally.touching
         : judged.meets    ? tally.meeting
         : judged.sign < 0 ? tally.inside
                           : tally.outside);
    }
  }
  static void expect_signs(const JudgedScene& scene, const FrameResult& r, SignTally& tally) {
    expect_signs(
        scene, r.vertex_triangle, [&](const auto& ids) { return scene.judge().of_vertex_triangle(ids); }, tally);
    if (HasFatalFailure()) return;
    expect_signs(
        scene, r.edge_edge, [&](const auto& ids) { return scene.judge().of_edge_edge(ids); }, tally);
  }
};

TEST_F(SignsJudged, AtEveryLevel) {
  SignTally tally;
  for (uint32_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const JudgedScene scene(random_pairs(seed, 12));
    const Accuracy accuracy = kLevels[seed % 4];
    const Scalar scalar = seed % 8 < 4 ? Scalar::kF32 : Scalar::kF64;
    expect_signs(scene, run_solids(scene.scene(), looking_for_signs(accuracy, scalar)), tally);
    if (HasFatalFailure()) return;
  }
  tally.print("signs");
  tally.expect_all();
}

/// A triangle in the plane of a cube's diagonals divides it, and its border is far outside: all that meets is a tie.
TEST_F(SignsJudged, NoneOfASheetThroughDiagonals) {
  SolidsScene scene;
  add_solid(scene, {unit_cube(), {}});
  MeshSpec sheet;
  sheet.vertex_count = 3, sheet.triangles = {{0, 1, 2}};
  add_surface(scene, sheet, {{-9, 10, -9}, {10, -9, -9}, {0.5, 0.5, 20}});
  SignTally tally;
  expect_signs(JudgedScene(scene), run_solids(scene, looking_for_signs(Accuracy::kExact, Scalar::kF64)), tally);
  EXPECT_GT(tally.meeting, 0u);
  EXPECT_EQ(tally.inside + tally.outside, 0u);
}

}  // namespace
}  // namespace collided::test
