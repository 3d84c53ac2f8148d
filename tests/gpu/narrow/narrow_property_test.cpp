// FAST on random input: what has to hold for every contact, and contacts that have to be there.

#include <algorithm>
#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/distance.hpp"

namespace collided::test {
namespace {

// Positions of a one- or many-mesh case at one time, by scene-wide feature ids.
class Geometry {
 public:
  Geometry(const Case& c, double t) : features_(features_of(c)) {
    for (size_t m = 0; m < c.start.size(); ++m)
      for (size_t v = 0; v < c.start[m].size(); ++v) points_.push_back(lerp(c.start[m][v], c.end[m][v], t));
  }
  Closest vertex_triangle(uint32_t v, uint32_t t) const { return point_triangle(points_[v], corners(t)); }
  Closest edges(uint32_t e, uint32_t f) const { return edge_edge(ends(e), ends(f)); }

  double between(const std::array<uint32_t, 2>& vt, const std::array<double, 2>& weights) const {
    return length_between(points_[vt[0]], point_of(corners(vt[1]), weights));
  }
  double between_edges(const std::array<uint32_t, 2>& ee, const std::array<double, 2>& weights) const {
    const auto e = ends(ee[0]), f = ends(ee[1]);
    return length_between(lerp(e[0], e[1], weights[0]), lerp(f[0], f[1], weights[1]));
  }

 private:
  std::array<Vec3d, 3> corners(uint32_t t) const {
    const auto& c = features_.triangles[t];
    return {points_[c[0]], points_[c[1]], points_[c[2]]};
  }
  std::array<Vec3d, 2> ends(uint32_t e) const {
    return {points_[features_.edges[e][0]], points_[features_.edges[e][1]]};
  }

  Features features_;
  Positions points_;
};

SceneSpec fast(Mode mode, Scalar scalar, double thickness = 0) {
  SceneSpec spec = settings(mode, Accuracy::kFast, scalar, thickness);
  spec.fields = spec.fields.with(ContactField::kWeights);
  return spec;
}

// Contacts are candidates, once each, in order; arrays agree in length.
void expect_well_formed(const ContactSet& contacts, const PairSet& candidates, Mode mode) {
  const std::vector<PairKey> keys = keys_of(contacts);
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end(), std::less_equal<>()));
  EXPECT_TRUE(std::includes(candidates.may.begin(), candidates.may.end(), keys.begin(), keys.end()));
  EXPECT_EQ(contacts.toi.size(), mode == Mode::kCcd ? contacts.size() : 0);
  EXPECT_EQ(contacts.distance.size(), contacts.size());
  EXPECT_EQ(contacts.weights.size(), contacts.size());
  EXPECT_EQ(contacts.flags.size(), contacts.size());
  for (double toi : contacts.toi) EXPECT_TRUE(toi >= 0 && toi <= 1) << toi;
  for (double distance : contacts.distance) EXPECT_GE(distance, 0);
}

class NarrowProperty : public OnBackend<::testing::TestWithParam<Scalar>> {
 protected:
  double tolerance() const { return GetParam() == Scalar::kF32 ? 2e-5 : 1e-9; }
  Case random_soup() const { return rounded(soup(7, 1500, 1, 0.1, 0.05), GetParam()); }
};

TEST_P(NarrowProperty, DiscreteDistancesAreThoseOfTheReference) {
  constexpr double kThickness = 0.02;
  const Case c = random_soup();
  const FrameResult r = run_case(c, fast(Mode::kDcd, GetParam(), kThickness));
  const ExpectedPairs candidates = brute_force(c, Mode::kDcd, GetParam(), kThickness);
  expect_well_formed(r.vertex_triangle, candidates.vertex_triangle, Mode::kDcd);
  expect_well_formed(r.edge_edge, candidates.edge_edge, Mode::kDcd);
  const Geometry g(c, 1);
  for (size_t i = 0; i < r.vertex_triangle.size(); ++i) {
    const auto [v, t] = r.vertex_triangle.elements[i];
    EXPECT_NEAR(r.vertex_triangle.distance[i], g.vertex_triangle(v, t).distance, tolerance());
    EXPECT_NEAR(g.between({v, t}, r.vertex_triangle.weights[i]), r.vertex_triangle.distance[i], tolerance());
  }
  for (size_t i = 0; i < r.edge_edge.size(); ++i) {
    const auto [e, f] = r.edge_edge.elements[i];
    EXPECT_NEAR(r.edge_edge.distance[i], g.edges(e, f).distance, tolerance());
    EXPECT_NEAR(g.between_edges({e, f}, r.edge_edge.weights[i]), r.edge_edge.distance[i], tolerance());
  }
}

// Every candidate clearly within the thickness is reported, none clearly beyond it.
TEST_P(NarrowProperty, DiscreteContactsAreThoseWithinTheThickness) {
  constexpr double kThickness = 0.02;
  const Case c = random_soup();
  const FrameResult r = run_case(c, fast(Mode::kDcd, GetParam(), kThickness));
  const ExpectedPairs candidates = brute_force(c, Mode::kDcd, GetParam(), kThickness);
  const Geometry g(c, 1);
  const auto expect_set = [&](const ContactSet& found, const PairSet& pairs, auto distance) {
    PairSet expected;
    for (PairKey key : pairs.may) {
      const double d = distance(static_cast<uint32_t>(key >> 32), static_cast<uint32_t>(key));
      if (d <= kThickness - tolerance()) expected.must.push_back(key);
      if (d <= kThickness + tolerance()) expected.may.push_back(key);
    }
    EXPECT_GT(expected.must.size(), 100u);
    EXPECT_EQ("", compare(found.elements, expected));
  };
  expect_set(r.vertex_triangle, candidates.vertex_triangle,
             [&](uint32_t v, uint32_t t) { return g.vertex_triangle(v, t).distance; });
  expect_set(r.edge_edge, candidates.edge_edge, [&](uint32_t e, uint32_t f) { return g.edges(e, f).distance; });
}

TEST_P(NarrowProperty, ContinuousContactsTouchAtTheirTime) {
  const Case c = random_soup();
  const FrameResult r = run_case(c, fast(Mode::kCcd, GetParam()));
  const ExpectedPairs candidates = brute_force(c, Mode::kCcd, GetParam(), 0);
  expect_well_formed(r.vertex_triangle, candidates.vertex_triangle, Mode::kCcd);
  expect_well_formed(r.edge_edge, candidates.edge_edge, Mode::kCcd);
  EXPECT_GT(r.vertex_triangle.size(), 20u);
  EXPECT_GT(r.edge_edge.size(), 20u);
  double earliest = 1;
  // Proximity at the root of the cubic: a small part of the features' size, whatever the working precision.
  constexpr double kNear = 1e-3;
  for (size_t i = 0; i < r.vertex_triangle.size(); ++i) {
    const auto [v, t] = r.vertex_triangle.elements[i];
    earliest = std::min(earliest, r.vertex_triangle.toi[i]);
    EXPECT_LT(Geometry(c, r.vertex_triangle.toi[i]).vertex_triangle(v, t).distance, kNear);
  }
  for (size_t i = 0; i < r.edge_edge.size(); ++i) {
    const auto [e, f] = r.edge_edge.elements[i];
    earliest = std::min(earliest, r.edge_edge.toi[i]);
    EXPECT_LT(Geometry(c, r.edge_edge.toi[i]).edges(e, f).distance, kNear);
  }
  EXPECT_EQ(r.earliest_toi, earliest);
}

// Triangle i of a random soup is far from all others and gets its own vertex, aimed at its inside at a known time.
struct Aimed {
  Case c;
  std::vector<double> times;
};

Aimed aimed_vertices(uint32_t count) {
  const Case source = soup(9, 3 * count, 1, 0.5, 0.3);
  Positions start, end;
  Aimed aimed;
  for (uint32_t i = 0; i < count; ++i) {
    const double time = 0.1 + 0.8 * (i + 0.5) / count, u = 0.2 + 0.3 * ((i * 7) % 10) / 10.0, w = 0.3;
    const Vec3d place{i * 4.0, 0, 0};
    const auto local = [&](const Positions& p, uint32_t k) {
      const Vec3d &x = p[9 * i + k], &origin = source.start[0][9 * i];
      return Vec3d{place[0] + x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]};
    };
    std::array<Vec3d, 3> at_time;
    for (uint32_t k = 0; k < 3; ++k) {
      start.push_back(local(source.start[0], k));
      end.push_back(local(source.end[0], k));
      at_time[k] = lerp(start.back(), end.back(), time);
    }
    const Vec3d hit = point_of(at_time, {u, w}), velocity{0.7, -1.1 + 0.1 * (i % 5), 2.3};
    for (double side : {0.0, 1e-3, 2e-3}) {  // a tiny triangle whose first corner hits
      Vec3d p, q;
      for (int k = 0; k < 3; ++k) {
        p[k] = hit[k] - time * velocity[k] - side * (k == 2) - 0.5 * side * (k == 1);
        q[k] = p[k] + velocity[k];
      }
      start.push_back(p);
      end.push_back(q);
    }
    aimed.times.push_back(time);
  }
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t v = 0; v < start.size(); v += 3) triangles.push_back({v, v + 1, v + 2});
  add_mesh(aimed.c, std::move(triangles), std::move(start), std::move(end));
  return aimed;
}

TEST_P(NarrowProperty, AimedVerticesHitNotLaterThanAimed) {
  constexpr uint32_t kCount = 200;
  Aimed aimed = aimed_vertices(kCount);
  aimed.c = rounded(aimed.c, GetParam());
  const FrameResult r = run_case(aimed.c, fast(Mode::kCcd, GetParam()));
  const std::vector<PairKey> keys = keys_of(r.vertex_triangle);
  // Floats far from the origin move the hit: their grid is 2^-14 at 800.
  const double late = GetParam() == Scalar::kF32 ? 5e-3 : 1e-6;
  for (uint32_t i = 0; i < kCount; ++i) {
    const auto at = std::lower_bound(keys.begin(), keys.end(), key_of(6 * i + 3, 2 * i));
    ASSERT_TRUE(at != keys.end() && *at == key_of(6 * i + 3, 2 * i)) << "vertex " << 6 * i + 3 << " missed";
    EXPECT_LE(r.vertex_triangle.toi[static_cast<size_t>(at - keys.begin())], aimed.times[i] + late) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Scalars, NarrowProperty, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

}  // namespace
}  // namespace collided::test
