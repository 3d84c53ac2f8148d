// Which contacts are covered, on which features they are, and normals where surfaces touch: random scenes against a
// judge in rationals, and boxes on floors by hand.

#include <cmath>
#include <numbers>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/narrow/covering_judge.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

using Triangles = std::vector<std::array<uint32_t, 3>>;

/// Opposite faces have parallel diagonals. Vertex i has the upper x, y, z where bits 0, 1, 2 of i are set.
const Triangles kBoxTriangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
Positions box(const Vec3d& lower, const Vec3d& upper) {
  Positions p;
  for (size_t i = 0; i < 8; ++i)
    p.push_back({i & 1 ? upper[0] : lower[0], i & 2 ? upper[1] : lower[1], i & 4 ? upper[2] : lower[2]});
  return p;
}

/// Turned about an axis through the origin, by an angle in radians, and moved.
Positions turned(Positions positions, const Vec3d& axis, double angle, const Vec3d& by = {}) {
  const double length = std::hypot(axis[0], axis[1], axis[2]), c = std::cos(angle), s = std::sin(angle);
  const Vec3d a = {axis[0] / length, axis[1] / length, axis[2] / length};
  for (Vec3d& p : positions) {
    const double along = (1 - c) * (a[0] * p[0] + a[1] * p[1] + a[2] * p[2]);
    p = {c * p[0] + s * (a[1] * p[2] - a[2] * p[1]) + along * a[0] + by[0],
         c * p[1] + s * (a[2] * p[0] - a[0] * p[2]) + along * a[1] + by[1],
         c * p[2] + s * (a[0] * p[1] - a[1] * p[0]) + along * a[2] + by[2]};
  }
  return positions;
}

/// A floor of cells around the origin, at the height that `height` gives. A static one has no contacts with itself.
template <class Height>
void add_floor(Case& c, uint32_t cells, double cell, const Height& height, bool is_static = true) {
  const double middle = cells * cell / 2;
  add_mesh(c, grid_triangles(cells + 1),
           grid(cells + 1,
                [&](double i, double j) {
                  const double x = i * cell - middle, y = j * cell - middle;
                  return Vec3d{x, y, height(x, y)};
                }),
           {}, is_static);
}
double flat(double, double) { return 0; }

class Random {
 public:
  explicit Random(uint32_t seed) : random_(seed) {}
  double number(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  int integer(int from, int to) { return std::uniform_int_distribution<int>(from, to)(random_); }
  Vec3d point(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }

 private:
  std::mt19937_64 random_;
};

/// Triangles of the vertices of a lattice, which they share.
void add_welded(Case& c, Random& random, int side, int count, const Vec3d& at) {
  Positions p;
  for (int i = 0; i < side * side * side; ++i)
    p.push_back({at[0] + i % side, at[1] + i / side % side, at[2] + i / side / side});
  Triangles triangles;
  while (static_cast<int>(triangles.size()) < count) {
    const auto any = [&] { return static_cast<uint32_t>(random.integer(0, side * side * side - 1)); };
    const std::array<uint32_t, 3> t = {any(), any(), any()};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
  }
  add_mesh(c, triangles, p);
}

Case welded(uint32_t seed, int side, int count) {
  Random random(seed);
  Case c;
  add_welded(c, random, side, count, {0, 0, 0});
  add_welded(c, random, side, count, {1, 0, 1});
  return c;
}

/// Boxes and octahedra in a heap, turned at random.
Case heap(uint32_t seed, int count, double size) {
  Random random(seed);
  const Triangles octahedron = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  Case c;
  for (int i = 0; i < count; ++i) {
    const bool is_box = i % 2 == 0;
    const Positions body =
        is_box ? box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5})
               : Positions{{-0.7, 0, 0}, {0.7, 0, 0}, {0, -0.7, 0}, {0, 0.7, 0}, {0, 0, 0.7}, {0, 0, -0.7}};
    add_mesh(c, is_box ? kBoxTriangles : octahedron,
             turned(body, random.point(1), random.number(0, 3), random.point(size)));
  }
  return c;
}

Case box_on_floor(const Positions& on_top, uint32_t cells = 8) {
  Case c;
  add_floor(c, cells, 0.025, flat, false);
  add_mesh(c, kBoxTriangles, on_top);
  return c;
}

/// Two boxes side by side that share a face x = -1, turned and moved alike.
Case flush_boxes(const Vec3d& axis, double angle, const Vec3d& by, bool is_swapped = false) {
  const Positions left = turned(box({-3, -1, 0}, {-1, 1, 2}), axis, angle, by),
                  right = turned(box({-1, -1, 0}, {1, 1, 2}), axis, angle, by);
  Case c;
  add_mesh(c, kBoxTriangles, is_swapped ? right : left);
  add_mesh(c, kBoxTriangles, is_swapped ? left : right);
  return c;
}

constexpr Accuracy kTellingLevels[] = {Accuracy::kFast, Accuracy::kCertified, Accuracy::kExact};

class Covering : public OnBackend<::testing::TestWithParam<Scalar>> {
 protected:
  SceneSpec telling(Accuracy accuracy, double thickness) const {
    SceneSpec spec = settings(Mode::kDcd, accuracy, GetParam(), thickness);
    spec.fields = kEveryField;
    return spec;
  }
  /// Expects what the judge says, at each level that can be.
  CoveringCounts judged(const Case& exact, double thickness) const {
    const Case c = rounded(exact, GetParam());
    const Frame frame(c, Mode::kDcd, GetParam());
    std::optional<CoveringJudge> judge;
    CoveringCounts counts;
    for (const Accuracy accuracy : kTellingLevels) {
      if (thickness == 0 && accuracy == Accuracy::kFast) continue;
      SCOPED_TRACE(accuracy == Accuracy::kFast ? "FAST" : accuracy == Accuracy::kExact ? "EXACT" : "CERTIFIED");
      const auto detector = Detector::create(spec_for(c, telling(accuracy, thickness)));
      if (!judge) judge.emplace(c, detector->topology());
      counts += judge->expect(detector->detect(frame.input()), accuracy, true, accuracy != Accuracy::kFast);
    }
    std::printf(
        "%zu contacts: %zu kept, %zu same, %zu nearer, %zu of crossing meshes; %zu shallow, %zu steep; "
        "%zu unsure; %zu descents, %zu left out\n",
        counts.contacts, counts.kept, counts.same, counts.nearer, counts.crossing, counts.shallow, counts.steep,
        counts.unsure, counts.descents, counts.left_out);
    return counts;
  }
};
INSTANTIATE_TEST_SUITE_P(Scalars, Covering, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

TEST_P(Covering, WeldedLattices) {
  CoveringCounts counts;
  for (const uint32_t seed : {1u, 2u, 3u}) counts += judged(welded(seed, 4, 8), 0.6);
  counts += judged(welded(4, 3, 8), 0);
  EXPECT_GT(counts.same, 300u);
  EXPECT_GT(counts.crossing, 300u);
}

TEST_P(Covering, SheetsWithThemselves) {
  Case smooth, rough;
  add_mesh(smooth, grid_triangles(9), shaken(flat_grid(9, 1), 5, 0.1));
  add_mesh(rough, grid_triangles(9), shaken(flat_grid(9, 1), 6, 0.9));
  const CoveringCounts of_smooth = judged(smooth, 1.2), of_rough = judged(rough, 0.3);
  EXPECT_EQ(of_smooth.crossing, 0u);
  EXPECT_GT(of_smooth.left_out, 100u) << "a sheet's minima are where it is one";
  EXPECT_GT(of_smooth.same, 100u);
  EXPECT_EQ(of_rough.crossing, of_rough.contacts);
}

TEST_P(Covering, SheetsOverEachOther) {
  Case c;
  for (const uint32_t i : {0u, 1u, 2u}) {
    Positions p = shaken(flat_grid(8, 1), 10 + i, 0.15);
    for (Vec3d& x : p) x[0] += 0.3 * i, x[1] += 0.4 * i, x[2] += 0.7 * i;
    add_mesh(c, grid_triangles(8), p);
  }
  const CoveringCounts counts = judged(c, 0.8);
  EXPECT_EQ(counts.crossing, 0u);
  EXPECT_GT(counts.descents, 500u);
  EXPECT_GT(counts.kept, 50u);
}

/// Two sheets over each other on a lattice, at heights of 0 and 1 more each.
Case terraces(uint32_t seed, double unit) {
  Random random(seed);
  Case c;
  for (const int i : {0, 1}) {
    Positions p = flat_grid(5, 1);
    for (Vec3d& x : p) x = {unit * (x[0] + i), unit * x[1], unit * (x[2] + 2 * i + random.integer(0, 1))};
    add_mesh(c, grid_triangles(5), p);
  }
  return c;
}

// Slopes of lattices, at which everything ties, and of tiny and huge ones.
TEST_P(Covering, Terraces) {
  CoveringCounts counts;
  for (const uint32_t seed : {1u, 2u}) counts += judged(terraces(seed, 1), 1.1);
  counts += judged(terraces(3, 0x1p-40), 1.1 * 0x1p-40);
  if (GetParam() == Scalar::kF64)
    for (const double unit : {0x1p-300, 0x1p200}) counts += judged(terraces(4, unit), 1.1 * unit);
  EXPECT_EQ(counts.crossing, 0u);
  EXPECT_EQ(counts.unsure, 0u);
  EXPECT_GT(counts.descents, 200u);
  EXPECT_GT(counts.kept, 30u);
}

TEST_P(Covering, ClosedBodies) {
  CoveringCounts counts;
  for (const uint32_t seed : {1u, 2u, 3u, 4u, 5u}) counts += judged(heap(seed, 8, 2), 0.4);
  EXPECT_GT(counts.descents, 300u);
  EXPECT_GT(counts.crossing, 100u);
  EXPECT_GT(counts.kept, 100u);
}

TEST_P(Covering, BoxesOnFloors) {
  CoveringCounts counts;
  const Positions small = box({-0.05, -0.05, 0.005}, {0.05, 0.05, 0.105});
  counts += judged(box_on_floor(turned(small, {0, 0, 1}, 0)), 0.02);
  counts += judged(box_on_floor(turned(small, {0, 0, 1}, 0.3, {0.003, 0.002, 0})), 0.02);
  counts += judged(box_on_floor(turned(small, {1, 2, 0}, 0.02, {0.0031, 0.0017, 0})), 0.02);
  counts += judged(box_on_floor(turned(small, {1, 2, 0}, 1e-9, {0, 0, -0.005})), 0.02);
  EXPECT_GT(counts.descents, 300u);
}

TEST_P(Covering, LooseElements) {
  CoveringCounts counts;
  counts += judged(loose_soup(21, 40, 1, 0.3, 0), 0.05);
  counts += judged(on_integers(loose_soup(22, 12, 4, 3, 0)), 0.9);
  Case c;
  for (const uint32_t i : {0u, 1u}) {
    Positions p = shaken(flat_grid(6, 1), 30 + i, 0.2);
    for (Vec3d& x : p) x[0] += 0.3 * i, x[2] += 0.9 * i;
    add_mesh(c, grid_triangles(6), p);
  }
  counts += judged(loosened(c), 0.9);
  EXPECT_GT(counts.descents, 200u);
}

// Vertices in one place, triangles without area or there twice, a corner of many triangles.
TEST_P(Covering, AdversarialFamilies) {
  CoveringCounts counts;
  for (const Case& c : adversarial_cases())
    if (c.name == "DuplicatedVertices" || c.name == "Fan") counts += judged(c, 1e-3);
  EXPECT_GT(counts.contacts, 500u);
}

// Surfaces that touch in corners, along sides and in faces.
TEST_P(Covering, NormalsAtDistanceZero) {
  CoveringCounts counts;
  for (const Case& c :
       {welded(7, 3, 8), welded(8, 3, 5), on_integers(loose_soup(23, 12, 3, 3, 0)), flush_boxes({0, 0, 1}, 0, {})})
    for (const Accuracy accuracy : {Accuracy::kCertified, Accuracy::kExact}) {
      const auto detector = Detector::create(spec_for(c, telling(accuracy, 0)));
      const Frame frame(c, Mode::kDcd, GetParam());
      counts += CoveringJudge(c, detector->topology()).expect_normals(detector->detect(frame.input()));
    }
  std::printf("%zu of faces, %zu of directions\n", counts.faces, counts.supports);
  EXPECT_GT(counts.faces, 200u);
  EXPECT_GT(counts.supports, 50u);
}

// Nothing is covered for contacts of one kind alone, but their features tell the same.
TEST_P(Covering, OfOneKind) {
  const Case c = rounded(heap(5, 4, 1.2), GetParam());
  const Frame frame(c, Mode::kDcd, GetParam());
  size_t nearer = 0;
  for (const bool of_edges : {false, true}) {
    SceneSpec spec = telling(Accuracy::kExact, 0.4);
    spec.kinds = {.vertex_triangle = !of_edges, .edge_edge = of_edges};
    const auto detector = Detector::create(spec_for(c, spec));
    CoveringJudge judge(c, detector->topology());
    const CoveringCounts counts = judge.expect(detector->detect(frame.input()), Accuracy::kExact, false, false);
    EXPECT_EQ(counts.kept, counts.contacts);
    nearer += counts.nearer;
  }
  EXPECT_GT(nearer, 100u);
}

// Boxes and floors by hand, as a solver meets them.

using CoveredBoxes = OnBackend<>;

FrameResult find(const Case& c, double thickness, Accuracy accuracy = Accuracy::kExact,
                 PerKind<bool> kinds = {.vertex_triangle = true, .edge_edge = true}) {
  SceneSpec spec = settings(Mode::kDcd, accuracy, Scalar::kF64, thickness);
  spec.fields = kEveryField;
  spec.kinds = kinds;
  return run_case(c, spec);
}

/// visit(set, place) of each contact that is not covered.
template <class Visit>
void for_each_kept(const FrameResult& found, const Visit& visit) {
  for (const ContactSet* set : {&found.vertex_triangle, &found.edge_edge})
    for (size_t i = 0; i < set->size(); ++i)
      if ((set->flags[i] & kFlagCovered) == 0) visit(*set, i);
}
size_t count_kept(const FrameResult& found) {
  size_t count = 0;
  for_each_kept(found, [&](const ContactSet&, size_t) { ++count; });
  return count;
}

/// The angle between a normal and a direction, whatever their signs, in degrees.
double degrees_between(const Normal& n, const Vec3d& d) {
  const double along = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
  const Vec3d across = {n[1] * d[2] - n[2] * d[1], n[2] * d[0] - n[0] * d[2], n[0] * d[1] - n[1] * d[0]};
  return std::atan2(std::hypot(across[0], across[1], across[2]), std::abs(along)) * 180 / std::numbers::pi;
}

TEST_F(CoveredBoxes, FlushBoxesHaveOneNormalAndFourContacts) {
  for (const bool is_swapped : {false, true})
    for (const Accuracy accuracy : {Accuracy::kCertified, Accuracy::kExact}) {
      const FrameResult found = find(flush_boxes({0, 0, 1}, 0, {}, is_swapped), 0, accuracy);
      EXPECT_EQ(count_contacts(found), 111u);
      EXPECT_EQ(count_kept(found), 4u);
      const auto expect_normal = [&](const ContactSet& set, bool first_is_of_first) {
        for (size_t i = 0; i < set.size(); ++i) {
          const bool first_is_left = (first_is_of_first ? set.elements[i][0] < 8u : true) != is_swapped;
          EXPECT_EQ(set.normals[i], (Normal{first_is_left ? -1.0f : 1.0f, 0, 0})) << i;
        }
      };
      expect_normal(found.vertex_triangle, true);
      expect_normal(found.edge_edge, false);
    }
}

// The common face is known to rounding alone, and what touches is what the thickness takes for it.
TEST_F(CoveredBoxes, TurnedFlushBoxesHaveTheFacesNormal) {
  Random random(3);
  for (int turn = 0; turn < 3; ++turn) {
    const Vec3d axis = random.point(1), by = random.point(2);
    const double angle = random.number(0, 3);
    const Vec3d face = turned({{1, 0, 0}}, axis, angle)[0];
    const FrameResult found = find(flush_boxes(axis, angle, by), 1e-12);
    size_t right = 0;
    for (const ContactSet* set : {&found.vertex_triangle, &found.edge_edge})
      for (const Normal& n : set->normals) right += degrees_between(n, face) < 0.01;
    std::printf("turn %d: %zu of %zu normals are the face's, %zu kept\n", turn, right, count_contacts(found),
                count_kept(found));
    for_each_kept(found, [&](const ContactSet& set, size_t i) {
      EXPECT_LT(degrees_between(set.normals[i], face), 0.01) << "turn " << turn << ", contact " << i;
    });
    EXPECT_EQ(right, count_contacts(found));
  }
}

/// A box of 20 cm over a floor of cells of 2.5 cm.
Case over_floor(const Positions& box) {
  Case c;
  add_floor(c, 40, 0.025, flat);
  add_mesh(c, kBoxTriangles, box);
  return c;
}
Positions box_of_20_cm(double height) { return box({-0.1, -0.1, height}, {0.1, 0.1, height + 0.2}); }

void expect_upright(const char* name, const Positions& box, double thickness, double tilt) {
  SCOPED_TRACE(name);
  for (const Accuracy accuracy : kTellingLevels) {
    const FrameResult found = find(over_floor(box), thickness, accuracy);
    const uint32_t first_of_box = 41 * 41;
    std::set<uint32_t> corners;
    for (size_t i = 0; i < found.vertex_triangle.size(); ++i)
      if ((found.vertex_triangle.flags[i] & kFlagCovered) == 0 && found.vertex_triangle.elements[i][0] >= first_of_box)
        corners.insert(found.vertex_triangle.elements[i][0] - first_of_box);
    EXPECT_EQ(corners, (std::set<uint32_t>{0, 1, 2, 3})) << "the lower corners";
    for_each_kept(found, [&](const ContactSet& set, size_t i) {
      EXPECT_LE(degrees_between(set.normals[i], {0, 0, 1}), tilt * 180 / std::numbers::pi + 0.9);
    });
    std::printf("%s: %zu of %zu kept\n", name, count_kept(found), count_contacts(found));
  }
}

TEST_F(CoveredBoxes, ABoxOverAFloorHasItsNormal) {
  const Vec3d aside = {0.0031, 0.0017, 0}, z = {0, 0, 1};
  expect_upright("plain", turned(box_of_20_cm(0.005), z, 0, aside), 0.02, 0);
  expect_upright("turned", turned(box_of_20_cm(0.005), z, 0.3, {0.003, 0.002, 0}), 0.02, 0);
  expect_upright("aligned", box_of_20_cm(0.005), 0.02, 0);
  expect_upright("at 1 mm", turned(box_of_20_cm(0.001), z, 0, aside), 0.01, 0);
  for (const double tilt : {1e-9, 1e-3, 1e-2})
    expect_upright("tilted", turned(box_of_20_cm(0.005), {2, 1, 0}, tilt, aside), 0.02, tilt);
}

// What is nearer tells nothing where meshes cross.
TEST_F(CoveredBoxes, ABoxInAFloorIsNotCoveredByWhatIsNearer) {
  const Case c = over_floor(turned(box_of_20_cm(-0.0015), {0, 1, 0}, 0.01, {0.0031, 0.0017, 0}));
  const FrameResult found =
      find(c, 0.02, Accuracy::kExact, {.vertex_triangle = true, .edge_edge = true, .edge_triangle = true});
  EXPECT_GT(found.edge_triangle.size(), 0u);
  size_t nearer = 0;
  for (const ContactSet* set : {&found.vertex_triangle, &found.edge_edge})
    for (size_t i = 0; i < set->size(); ++i) {
      EXPECT_EQ((set->flags[i] & kFlagCovered) != 0, (set->features[i] & kSameAsBefore) != 0);
      nearer += (set->features[i] & (kNearerAtFirst | kNearerAtSecond)) != 0;
    }
  EXPECT_GT(nearer, 100u);
}

TEST_F(CoveredBoxes, AValleyAndARidge) {
  const double slope = std::tan(5 * std::numbers::pi / 180);
  for (const bool is_ridge : {false, true}) {
    Case c;
    add_floor(c, 40, 0.025, [&](double x, double) { return (is_ridge ? -1 : 1) * std::abs(x) * slope; });
    add_mesh(c, kBoxTriangles, turned(box_of_20_cm(is_ridge ? 0.005 : 0.012), {0, 0, 1}, 0, {0.0031, 0.0017, 0}));
    const FrameResult found = find(c, 0.02);
    size_t count = 0;
    for_each_kept(found, [&](const ContactSet& set, size_t i) {
      ++count;
      const double to_face =
          std::min(degrees_between(set.normals[i], {slope, 0, 1}), degrees_between(set.normals[i], {-slope, 0, 1}));
      EXPECT_LE(is_ridge ? degrees_between(set.normals[i], {0, 0, 1}) : to_face, 5.0) << "contact " << i;
    });
    std::printf("%s: %zu of %zu kept\n", is_ridge ? "ridge" : "valley", count, count_contacts(found));
    EXPECT_GE(count, 4u);
  }
}

TEST_F(CoveredBoxes, AVertexOverAFloorsDiagonal) {
  Case c;
  add_floor(c, 2, 1, flat);
  add_mesh(c, {{0, 1, 2}}, {{-0.5, -0.5, 0.001}, {-0.4, -0.5, 1}, {-0.5, -0.4, 1}});
  const FrameResult found = find(c, 0.01);
  ASSERT_EQ(count_kept(found), 1u);
  for_each_kept(found, [&](const ContactSet& set, size_t i) {
    ASSERT_EQ(&set, &found.vertex_triangle);
    const int side = set.features[i] & kOfTriangle;
    EXPECT_TRUE(side >= 1 && side <= 3) << side;
    EXPECT_LT(degrees_between(set.normals[i], {0, 0, 1}), 1e-5);
  });
}

}  // namespace
}  // namespace collided::test
