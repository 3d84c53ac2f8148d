// Contours against a brute-force judge, which goes through all pairs of triangles.

#include "client/cpp/contours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "client/cpp/error.hpp"
#include "gpu/exact/crossings.hpp"

namespace collided::client {
namespace {

using Point = std::array<double, 3>;
using Edge = std::array<uint32_t, 2>;
using Triangle = std::array<uint32_t, 3>;

/// Meshes of triangles and where their vertices are.
struct Surfaces {
  struct Mesh {
    uint32_t vertex_count;
    std::vector<Triangle> triangles;
    std::vector<Edge> loose_edges = {};
  };
  std::vector<Mesh> meshes;
  std::vector<Point> positions;

  std::vector<MeshInput> inputs() const {
    std::vector<MeshInput> out;
    for (const Mesh& mesh : meshes)
      out.push_back({.vertex_count = mesh.vertex_count, .triangles = mesh.triangles, .edges = mesh.loose_edges});
    return out;
  }
};

/// All edges and triangles of a scene in the order of their ids, without SceneFeatures.
struct Features {
  std::vector<Triangle> triangles;  ///< a b b of a loose edge
  std::vector<Edge> edges;

  explicit Features(const Surfaces& surfaces) {
    std::set<Edge> sides;
    uint32_t base = 0;
    for (const Surfaces::Mesh& mesh : surfaces.meshes) {
      for (const Triangle& t : mesh.triangles) triangles.push_back({base + t[0], base + t[1], base + t[2]});
      for (const Edge& e : mesh.loose_edges) triangles.push_back({base + e[0], base + e[1], base + e[1]});
      base += mesh.vertex_count;
    }
    for (const Triangle& t : triangles)
      for (const auto& [a, b] : {Edge{t[0], t[1]}, Edge{t[1], t[2]}, Edge{t[2], t[0]}})
        if (a != b) sides.insert({std::min(a, b), std::max(a, b)});
    edges.assign(sides.begin(), sides.end());
  }
  bool is_triangle(uint32_t t) const { return triangles[t][1] != triangles[t][2]; }
  bool has(uint32_t t, uint32_t vertex) const { return std::ranges::count(triangles[t], vertex) > 0; }
  bool has_edge(uint32_t t, uint32_t e) const { return has(t, edges[e][0]) && has(t, edges[e][1]); }
  size_t count_triangles(uint32_t edge) const {
    size_t count = 0;
    for (uint32_t t = 0; t < triangles.size(); ++t) count += is_triangle(t) && has_edge(t, edge) ? 1 : 0;
    return count;
  }
};

/// The contacts of the kind edge-triangle that an exact daemon finds.
Contacts crossings_of(const Surfaces& surfaces) {
  const Features features(surfaces);
  Contacts out;
  for (uint32_t e = 0; e < features.edges.size(); ++e)
    for (uint32_t t = 0; t < features.triangles.size(); ++t) {
      const auto& [u, v] = features.edges[e];
      if (!features.is_triangle(t) || features.has(t, u) || features.has(t, v)) continue;
      const auto& [a, b, c] = features.triangles[t];
      const uint32_t ids[5] = {u, v, a, b, c};
      Vec3<double> points[5];
      for (size_t i = 0; i < 5; ++i) {
        const Point& p = surfaces.positions[ids[i]];
        points[i] = {p[0], p[1], p[2]};
      }
      const EdgeTriangleVerdict verdict = exact_edge_triangle(points, ids);
      if (!verdict.crosses) continue;
      ++out.count;
      out.elements.push_back({e, t});
      out.weights.push_back({verdict.weights[0], verdict.weights[1]});
    }
  return out;
}

/// An end of a segment: a crossing, or a point that is a common corner.
using End = std::pair<uint32_t, Point>;
using Segment = std::pair<End, End>;

Segment segment(const Contour::Point& a, const Contour::Point& b) {
  const auto end = [](const Contour::Point& p) {
    return End{p.crossing, p.crossing == kNoCrossing ? p.position : Point{}};
  };
  return std::minmax(end(a), end(b));
}

/// The segments in which any two triangles cross, each with its ends.
std::multiset<Segment> judged_segments(const Surfaces& surfaces, const Contacts& crossings) {
  const Features features(surfaces);
  std::multiset<Segment> out;
  for (uint32_t s = 0; s < features.triangles.size(); ++s)
    for (uint32_t t = s + 1; t < features.triangles.size(); ++t) {
      if (!features.is_triangle(s) || !features.is_triangle(t)) continue;
      std::vector<Contour::Point> ends;
      for (uint32_t i = 0; i < crossings.count; ++i) {
        const auto& [edge, triangle] = crossings.elements[i];
        if ((triangle == t && features.has_edge(s, edge)) || (triangle == s && features.has_edge(t, edge)))
          ends.push_back({{}, i});
      }
      if (ends.empty()) continue;
      for (const uint32_t corner : features.triangles[s])
        if (features.has(t, corner)) ends.push_back({surfaces.positions[corner], kNoCrossing});
      EXPECT_EQ(ends.size(), 2u) << "triangles " << s << " and " << t;
      if (ends.size() == 2) out.insert(segment(ends[0], ends[1]));
    }
  return out;
}

std::multiset<Segment> segments_of(const std::vector<Contour>& contours) {
  std::multiset<Segment> out;
  for (const Contour& contour : contours) {
    const auto& points = contour.points;
    for (size_t i = 1; i < points.size(); ++i) out.insert(segment(points[i - 1], points[i]));
    if (contour.is_closed) out.insert(segment(points.back(), points.front()));
  }
  return out;
}

/// How often each crossing is a point of a contour.
std::vector<int> uses_of(const std::vector<Contour>& contours, uint64_t count) {
  std::vector<int> uses(count);
  for (const Contour& contour : contours)
    for (const Contour::Point& point : contour.points)
      if (point.crossing != kNoCrossing) ++uses.at(point.crossing);
  return uses;
}

std::vector<Contour> joined(const Surfaces& surfaces, const Contacts& crossings) {
  return join_crossings(crossings, SceneFeatures(surfaces.inputs()), surfaces.positions);
}

/// Checks what holds of all contours of surfaces in which no edge has more than two triangles. Returns them.
std::vector<Contour> judge(const Surfaces& surfaces) {
  const Features features(surfaces);
  const Contacts crossings = crossings_of(surfaces);
  const std::vector<Contour> contours = joined(surfaces, crossings);
  EXPECT_EQ(segments_of(contours), judged_segments(surfaces, crossings));
  EXPECT_EQ(uses_of(contours, crossings.count), std::vector<int>(crossings.count, 1));
  uint32_t last = 0;
  for (const Contour& contour : contours) {
    const uint32_t first = std::ranges::min_element(contour.points, {}, &Contour::Point::crossing)->crossing;
    EXPECT_TRUE(last <= first && first != kNoCrossing) << "contours come in the order of their first crossings";
    last = first;
    if (contour.is_closed) continue;
    for (const Contour::Point& end : {contour.points.front(), contour.points.back()})
      if (end.crossing != kNoCrossing) {
        EXPECT_LT(features.count_triangles(crossings.elements[end.crossing][0]), 2u) << "it ends at a border";
      }
  }
  return contours;
}

class Lattice {
 public:
  explicit Lattice(uint32_t seed) : random_(seed) {}
  Point point(int size) {
    std::uniform_int_distribution<int> coordinate(0, size - 1);
    return {double(coordinate(random_)), double(coordinate(random_)), double(coordinate(random_))};
  }
  /// A closed surface with its vertices anywhere: four, six or twelve faces, flat ones among them.
  void add_solid(Surfaces& surfaces, int size) {
    static const std::vector<Surfaces::Mesh> kShapes{
        {4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}},
        {5, {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {1, 0, 4}, {2, 1, 4}, {0, 2, 4}}},
        {8,
         {{0, 2, 3},
          {0, 3, 1},
          {4, 5, 7},
          {4, 7, 6},
          {0, 1, 5},
          {0, 5, 4},
          {2, 6, 7},
          {2, 7, 3},
          {0, 4, 6},
          {0, 6, 2},
          {1, 3, 7},
          {1, 7, 5}}}};
    add(surfaces, kShapes[std::uniform_int_distribution<size_t>(0, kShapes.size() - 1)(random_)], size);
  }
  /// A sheet of cells with its vertices anywhere.
  void add_sheet(Surfaces& surfaces, uint32_t cells, int size) {
    Surfaces::Mesh mesh{(cells + 1) * (cells + 1), {}};
    for (uint32_t y = 0; y < cells; ++y)
      for (uint32_t x = 0; x < cells; ++x) {
        const uint32_t v = y * (cells + 1) + x;
        mesh.triangles.push_back({v, v + 1, v + cells + 2});
        mesh.triangles.push_back({v, v + cells + 2, v + cells + 1});
      }
    add(surfaces, mesh, size);
  }

 private:
  void add(Surfaces& surfaces, const Surfaces::Mesh& mesh, int size) {
    surfaces.meshes.push_back(mesh);
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) surfaces.positions.push_back(point(size));
  }
  std::mt19937 random_;
};

TEST(Contours, OfSolidsAreClosedWhereverTheyLie) {
  size_t contour_count = 0;
  for (uint32_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    Lattice lattice(seed);
    Surfaces surfaces;
    for (int solid = 0; solid < 2; ++solid) lattice.add_solid(surfaces, 3 + static_cast<int>(seed % 4));
    for (const Contour& contour : judge(surfaces)) {
      if (contour.meshes[0] == contour.meshes[1]) continue;  // neighbours of one surface meet at corners
      EXPECT_TRUE(contour.is_closed);
      EXPECT_EQ(contour.meshes, (std::array<uint32_t, 2>{0, 1}));
      ++contour_count;
    }
  }
  EXPECT_GT(contour_count, 200u);
}

TEST(Contours, OfASolidWithItselfEndAtCommonCornersAlone) {
  size_t corners = 0;
  for (uint32_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    Lattice lattice(seed);
    Surfaces surfaces;
    lattice.add_solid(surfaces, 4);
    for (const Contour& contour : judge(surfaces)) {
      for (size_t i = 0; i < contour.points.size(); ++i) {
        if (contour.points[i].crossing != kNoCrossing) continue;
        EXPECT_TRUE(!contour.is_closed && (i == 0 || i + 1 == contour.points.size()));
        ++corners;
      }
      if (!contour.is_closed) {
        EXPECT_EQ(contour.points.front().crossing, kNoCrossing);
        EXPECT_EQ(contour.points.back().crossing, kNoCrossing);
      }
    }
  }
  EXPECT_GT(corners, 100u);
}

TEST(Contours, OfSheetsEndAtBordersOrCommonCorners) {
  size_t open = 0, closed = 0;
  for (uint32_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    Lattice lattice(seed);
    Surfaces surfaces;
    lattice.add_sheet(surfaces, 3, 5);
    lattice.add_sheet(surfaces, 2, 5);
    for (const Contour& contour : judge(surfaces)) ++(contour.is_closed ? closed : open);
  }
  EXPECT_GT(open, 1000u);
  EXPECT_GT(closed, 100u);
}

/// The page on conventions has this example: two triangles that share the corner 0.
TEST(Contours, OfNeighboursBeginAtTheirCorner) {
  const Surfaces folded{{{5, {{0, 1, 2}, {0, 3, 4}}}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, 1, -1}, {2, 1.5, 2}}};
  const std::vector<Contour> contours = judge(folded);
  ASSERT_EQ(contours.size(), 1u);
  EXPECT_EQ(contours[0].meshes, (std::array<uint32_t, 2>{0, 0}));
  EXPECT_FALSE(contours[0].is_closed);
  std::map<uint32_t, Point> points;
  for (const Contour::Point& point : contours[0].points) points[point.crossing] = point.position;
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[kNoCrossing], (Point{0, 0, 0}));
  EXPECT_DOUBLE_EQ(points[0][0], 2);
  EXPECT_DOUBLE_EQ(points[0][1], 7.0 / 6);
  EXPECT_DOUBLE_EQ(points[0][2], 0);
}

/// A triangle, and four sheets of one triangle each that meet at an edge through it.
TEST(Contours, EndWhereSeveralMeetAtOneEdge) {
  Surfaces star{{{3, {{0, 1, 2}}}, {6, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 1, 5}}}},
                {{-9, -9, 0},
                 {9, -9, 0},
                 {0, 9, 0},
                 {0, 0, -1},
                 {0, 0, 2},
                 {3, 1, 0.5},
                 {-3, 1, 0.5},
                 {1, 4, 0.5},
                 {1, -4, 0.5}}};
  const Contacts crossings = crossings_of(star);
  ASSERT_EQ(crossings.count, 5u);
  const std::vector<Contour> contours = joined(star, crossings);
  EXPECT_EQ(contours.size(), 4u);
  EXPECT_EQ(segments_of(contours), judged_segments(star, crossings));
  const std::vector<int> uses = uses_of(contours, crossings.count);
  EXPECT_EQ(std::multiset<int>(uses.begin(), uses.end()), (std::multiset<int>{1, 1, 1, 1, 4}));
}

TEST(Contours, OfALooseEdgeAreAPoint) {
  const Surfaces hair{{{3, {{0, 1, 2}}}, {2, {}, {{1, 0}}}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 3}}};
  const std::vector<Contour> contours = judge(hair);
  ASSERT_EQ(contours.size(), 1u);
  ASSERT_EQ(contours[0].points.size(), 1u);
  EXPECT_EQ(contours[0].points[0].position, (Point{1, 1, 0}));
  EXPECT_FALSE(contours[0].is_closed);
}

TEST(Contours, EndWhereTheNextCrossingIsLeftOut) {
  const Surfaces solids{
      {{4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}}, {4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}}},
      {{0, 0, 0}, {6, 0, 0}, {0, 6, 0}, {0, 0, 6}, {1, 1, 1}, {7, 1, 1}, {1, 7, 1}, {1, 1, 7}}};
  Contacts crossings = crossings_of(solids);
  std::vector<Contour> contours = joined(solids, crossings);
  ASSERT_EQ(contours.size(), 1u);
  ASSERT_TRUE(contours[0].is_closed);
  const size_t points = contours[0].points.size();
  crossings.elements.pop_back(), crossings.weights.pop_back(), --crossings.count;
  contours = joined(solids, crossings);
  ASSERT_EQ(contours.size(), 1u);
  EXPECT_FALSE(contours[0].is_closed);
  EXPECT_EQ(contours[0].points.size(), points - 1);
}

int code_of(const Surfaces& surfaces, const Contacts& crossings) {
  try {
    joined(surfaces, crossings);
  } catch (const Error& error) {
    return error.code();
  }
  return 0;
}

TEST(Contours, RefuseWhatNoDaemonFinds) {
  constexpr int kInvalidArgument = 3, kDataLoss = 15;
  const Surfaces two{{{3, {{0, 1, 2}}}, {3, {{0, 1, 2}}}},
                     {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 1}, {1, 2, 1}}};
  Contacts crossings = crossings_of(two);
  EXPECT_EQ(crossings.count, 2u);
  EXPECT_EQ(code_of(two, crossings), 0);
  for (const auto& wrong : {std::array<uint32_t, 2>{6, 0}, {3, 2}}) {
    Contacts bad = crossings;
    bad.elements[0] = wrong;
    EXPECT_EQ(code_of(two, bad), kDataLoss);
  }
  Contacts repeated = crossings;
  repeated.count = 3, repeated.elements.push_back(repeated.elements[0]), repeated.weights.push_back({0, 0});
  EXPECT_EQ(code_of(two, repeated), kDataLoss);
  Contacts bare = crossings;
  bare.weights.clear();
  EXPECT_EQ(code_of(two, bare), kInvalidArgument);
  Surfaces fewer = two;
  fewer.positions.pop_back();
  EXPECT_EQ(code_of(fewer, crossings), kInvalidArgument);
}

TEST(SceneFeatures, HaveTheIdsOfConventions) {
  const std::vector<Triangle> square{{0, 1, 2}, {0, 2, 3}}, single{{0, 1, 2}};
  const std::vector<Edge> strand{{1, 0}, {1, 2}};
  const std::vector<uint32_t> drops{1, 0};
  const std::vector<MeshInput> meshes{{.vertex_count = 4, .triangles = square},
                                      {.vertex_count = 3, .triangles = single},
                                      {.vertex_count = 3, .edges = strand},
                                      {.vertex_count = 2, .points = drops}};
  const SceneFeatures scene(meshes);
  std::vector<Edge> edges;
  for (uint32_t id = 0; id < 10; ++id) edges.push_back(scene.edge(id));
  EXPECT_EQ(edges, (std::vector<Edge>{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {2, 3}, {4, 5}, {4, 6}, {5, 6}, {7, 8}, {8, 9}}));
  EXPECT_THROW(scene.edge(10), Error);
  std::vector<Triangle> elements;
  for (uint32_t id = 0; id < 7; ++id) elements.push_back(scene.element(id));
  EXPECT_EQ(elements,
            (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {8, 7, 7}, {8, 9, 9}, {11, 11, 11}, {10, 10, 10}}));
  EXPECT_THROW(scene.element(7), Error);
  const auto triangles = [&](uint32_t edge) {
    const auto own = scene.triangles_of(edge);
    return std::vector<uint32_t>(own.begin(), own.end());
  };
  EXPECT_EQ(triangles(1), (std::vector<uint32_t>{0, 1}));
  EXPECT_EQ(triangles(5), (std::vector<uint32_t>{2}));
  EXPECT_TRUE(triangles(9).empty());
  EXPECT_EQ(scene.mesh_of_edge(4), 0u);
  EXPECT_EQ(scene.mesh_of_edge(5), 1u);
  EXPECT_EQ(scene.mesh_of_edge(9), 2u);
  EXPECT_EQ(scene.mesh_of_element(6), 3u);
  EXPECT_EQ(scene.mesh_of_vertex(10), 3u);
  EXPECT_EQ(scene.first_vertex(2), 7u);
  EXPECT_EQ(scene.first_element(2), 3u);
  EXPECT_EQ(scene.vertex_count(), 12u);
  EXPECT_THROW(scene.mesh_of_vertex(12), Error);
}

}  // namespace
}  // namespace collided::client
