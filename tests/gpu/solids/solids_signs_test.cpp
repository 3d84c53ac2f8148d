// Distances with a sign against the judge: which closest points are in the other solid, and which features go through
// the other's mesh.

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
  uint64_t inside = 0, outside = 0, none = 0, tied = 0, open = 0, turned = 0;
  uint64_t tied_wrong = 0, tied_none = 0, tied_number = 0;

  void print(const char* of) const {
    std::cout << of << ": inside " << inside << ", outside " << outside << ", without a sign " << none << ", normals "
              << turned << ", several closest points " << open << "; of features that touch " << tied << ": other sign "
              << tied_wrong << ", none " << tied_none << ", a sign where there is none " << tied_number << "\n";
  }
};

/// The sign that an answer has; 0: NaN.
int sign_in(const ContactSet& set, size_t i) {
  const double value = set.signed_distance[i];
  if (std::isnan(value)) return 0;
  EXPECT_EQ(std::abs(value), set.distance[i]);
  return value < 0 ? -1 : 1;
}

/// With the distance it leads from the second feature's closest point to the first one's.
bool leads_apart(const ContactSet& set, size_t i, const JudgedSign& judged) {
  const Normal& n = set.normals[i];
  const auto& d = judged.apart;
  const long double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  if (length == 0) return true;
  const long double along = (n[0] * d[0] + n[1] * d[1] + n[2] * d[2]) / length;
  return (sign_in(set, i) < 0 ? -along : along) > 1 - 0x1p-18L;
}

class SignsJudged : public OnBackend<> {
 protected:
  /// Two solids in each slot, or one and a sheet, or two sheets.
  static SolidsScene random_pairs(uint32_t seed, int slots) {
    RandomBodies random(seed);
    SolidsScene scene;
    for (int i = 0; i < slots; ++i) {
      const Vec3d at{8.0 * (i % 8), 8.0 * (i / 8), 0};
      for (int k = 0; k < 2; ++k) {
        Body body = moved(random.shuffled(random.convex(3)), at);
        if (k == random.below(4)) body.pieces = {};
        add_solid(scene, body);
        scene.c.meshes.back().solid = !body.pieces.within.empty();
      }
    }
    return scene;
  }
  /// Compares the signs of all contacts; those of features that touch the other's mesh are counted.
  template <class Judged>
  static void expect_signs(const JudgedScene& scene, const ContactSet& set, const Judged& judged_of, SignTally& tally,
                           bool expects_tied) {
    for (size_t i = 0; i < set.size(); ++i) {
      const auto& ids = set.elements[i];
      const JudgedSign judged = judged_of(ids);
      const int sign = sign_in(set, i);
      ASSERT_TRUE(judged.is_open || leads_apart(set, i, judged)) << ids[0] << " " << ids[1];
      ++tally.turned;
      if (set.distance[i] == 0 && sign != 0 && judged.sign != 0) continue;
      if (judged.is_open) {
        ++tally.open;
        continue;
      }
      if (judged.is_tied) {
        ++tally.tied;
        tally.tied_wrong += sign * judged.sign < 0, tally.tied_none += sign == 0 && judged.sign != 0;
        tally.tied_number += sign != 0 && judged.sign == 0;
        if (!expects_tied) continue;
      }
      ++(judged.sign < 0 ? tally.inside : judged.sign > 0 ? tally.outside : tally.none);
      ASSERT_EQ(sign, judged.sign) << ids[0] << " " << ids[1] << " distance " << set.distance[i]
                                   << scene.text_of({0, 1});
    }
  }
  static void expect_signs(const JudgedScene& scene, const FrameResult& r, SignTally& tally, bool expects_tied) {
    expect_signs(
        scene, r.vertex_triangle, [&](const auto& ids) { return scene.judge().of_vertex_triangle(ids); }, tally,
        expects_tied);
    expect_signs(
        scene, r.edge_edge, [&](const auto& ids) { return scene.judge().of_edge_edge(ids); }, tally, expects_tied);
  }
};

TEST_F(SignsJudged, AtEveryLevel) {
  SignTally tally;
  for (uint32_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const JudgedScene scene(random_pairs(seed, 12));
    const Accuracy accuracy = kLevels[seed % 4];
    const Scalar scalar = seed < 3 ? Scalar::kF32 : Scalar::kF64;
    expect_signs(scene, run_solids(scene.scene(), looking_for_signs(accuracy, scalar)), tally, false);
    if (HasFatalFailure()) return;
  }
  tally.print("signs");
  for (const uint64_t count : {tally.inside, tally.outside, tally.none}) EXPECT_GT(count, 0u);
}

}  // namespace
}  // namespace collided::test
