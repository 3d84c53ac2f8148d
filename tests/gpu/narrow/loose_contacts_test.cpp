// Contacts of loose points with edges and points: what FAST finds of them, and that all that is told of them is a
// number. What the other levels promise: levels_test.cpp.

#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

constexpr Accuracy kLevels[] = {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact};

class LooseContacts : public OnBackend<::testing::TestWithParam<Scalar>> {
 protected:
  static SceneSpec spec(Mode mode, Accuracy accuracy, double thickness) {
    SceneSpec spec = settings(mode, accuracy, GetParam(), thickness);
    spec.fields = kEveryField;
    return spec;
  }
  static Case random() { return rounded(loose_soup(20, 150, 1, 0.2, 0.2), GetParam()); }
  /// Points and edges that coincide, touch, and have no length.
  static Case integers() { return on_integers(loose_soup(21, 60, 4, 4, 4)); }
};

/// The pairs of a vertex and an element that is no triangle.
std::vector<std::array<uint32_t, 2>> with_loose(const FrameResult& result, const Features& f) {
  std::vector<std::array<uint32_t, 2>> loose;
  for (const auto& pair : result.vertex_triangle.elements)
    if (f.kinds[pair[1]] != ElementKind::kTriangle) loose.push_back(pair);
  return loose;
}

/// FAST misses no contact of the judge and is not late beyond rounding; what it reports is within the thickness, or
/// nearly, at its time.
void expect_followed(const Case& c, const SceneSpec& spec, size_t least) {
  const double near = spec.scalar == Scalar::kF32 ? 2e-3 : 1e-6;
  SceneSpec all = spec;
  all.accuracy = Accuracy::kCandidates;
  const Features features = features_of(c);
  const auto pairs = with_loose(run_case(c, all), features);
  const Truth truth = CaseJudge(c, Mode::kCcd, spec.thickness).vertex_triangle(pairs);
  EXPECT_GE(truth.size(), least);
  const ContactSet found = run_case(c, spec).vertex_triangle;
  size_t met = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    const auto [vertex, element] = found.elements[i];
    if (features.kinds[element] == ElementKind::kTriangle) continue;
    EXPECT_LE(found.distance[i], spec.thickness + near);
    EXPECT_EQ(found.flags[i], found.toi[i] == 0 ? kFlagInitial : 0);
    const auto judged = truth.find(key_of(vertex, element));
    if (judged == truth.end()) continue;
    EXPECT_LE(found.toi[i], judged->second.upper.get_d() + near);
    ++met;
  }
  EXPECT_EQ(met, truth.size()) << "missed";
}

TEST_P(LooseContacts, AreFollowedAtFast) {
  expect_followed(random(), spec(Mode::kCcd, Accuracy::kFast, 0x1p-6), 20);
  expect_followed(integers(), spec(Mode::kCcd, Accuracy::kFast, 0), 20);
  expect_followed(integers(), spec(Mode::kCcd, Accuracy::kFast, 0.5), 20);
}

TEST_P(LooseContacts, OfOneFrameAreThoseWithinTheThickness) {
  constexpr double kThickness = 0.05, kNear = 1e-6;
  const Case c = random();
  const SceneSpec fast = spec(Mode::kDcd, Accuracy::kFast, kThickness);
  const FrameResult found = run_case(c, fast);
  SceneSpec all = fast;
  all.accuracy = Accuracy::kCandidates;
  const auto pairs = with_loose(run_case(c, all), features_of(c));
  const Truth must = CaseJudge(c, Mode::kDcd, kThickness - kNear).vertex_triangle(pairs);
  const Truth may = CaseJudge(c, Mode::kDcd, kThickness + kNear).vertex_triangle(pairs);
  EXPECT_GT(must.size(), 20u);
  EXPECT_EQ("", compare(with_loose(found, features_of(c)), {keys_of(must), keys_of(may)}));
}

void expect_numbers(const ContactSet& set) {
  for (size_t i = 0; i < set.size(); ++i) {
    EXPECT_TRUE(std::isfinite(set.distance[i]) && set.distance[i] >= 0);
    EXPECT_TRUE(std::isfinite(set.weights[i][0]) && std::isfinite(set.weights[i][1]));
    EXPECT_NEAR(std::hypot(set.normals[i][0], set.normals[i][1], set.normals[i][2]), 1, 1e-6);
    if (!set.toi.empty()) {
      EXPECT_TRUE(set.toi[i] >= 0 && set.toi[i] <= 1);
    }
  }
}

TEST_P(LooseContacts, AreToldInNumbers) {
  const Case c = integers();
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const Accuracy accuracy : kLevels)
      for (const double thickness : {0.0, 1.0}) {
        if (mode == Mode::kDcd && accuracy == Accuracy::kFast && thickness == 0) continue;  // refused
        SCOPED_TRACE(level_name(accuracy));
        const FrameResult r = run_case(c, spec(mode, accuracy, thickness));
        EXPECT_GT(with_loose(r, features_of(c)).size(), 10u);
        expect_numbers(r.vertex_triangle);
        expect_numbers(r.edge_edge);
      }
}

// From the edge's first vertex; there is no third corner.
TEST_P(LooseContacts, HaveTheWeightsOfWhatTheyTouch) {
  const Case c = random();
  const Features features = features_of(c);
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const Accuracy accuracy : kLevels) {
      const ContactSet found = run_case(c, spec(mode, accuracy, 0.05)).vertex_triangle;
      size_t inside = 0;
      for (size_t i = 0; i < found.size(); ++i) {
        const ElementKind kind = features.kinds[found.elements[i][1]];
        if (kind == ElementKind::kTriangle) continue;
        const auto [w0, w1] = found.weights[i];
        EXPECT_EQ(w1, 0);
        EXPECT_TRUE(kind == ElementKind::kEdge ? w0 >= 0 && w0 <= 1 : w0 == 0) << w0;
        inside += w0 > 0 && w0 < 1 ? 1 : 0;
      }
      EXPECT_GT(inside, 5u);
    }
}

INSTANTIATE_TEST_SUITE_P(Scalars, LooseContacts, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

}  // namespace
}  // namespace collided::test
