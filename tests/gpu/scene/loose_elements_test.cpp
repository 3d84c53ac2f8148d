// Loose edges and points: their numbers, which pairs of features are theirs, and what is refused.

#include <functional>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/brute_force.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

using Elements = std::vector<std::array<uint32_t, 2>>;
using LooseElements = OnBackend<>;

Elements elements_of(const ContactSet& contacts) { return {contacts.elements.begin(), contacts.elements.end()}; }

/// A mesh of one element, whose vertices lie along x at the height z: a triangle, a loose edge or a loose point.
void add_element(Case& c, int vertices, double z) {
  Positions positions = {{0.25, 0.25, z}, {1.25, 0.25, z}, {0.25, 1.25, z}};
  positions.resize(static_cast<size_t>(vertices));
  add_mesh(c, {}, std::move(positions));
  MeshSpec& mesh = c.meshes.back();
  if (vertices == 3) mesh.triangles = {{0, 1, 2}};
  if (vertices == 2) mesh.edges = {{0, 1}};
  if (vertices == 1) mesh.points = {0};
}

/// Contacts of two such elements above each other, of `first` and `second` vertices.
FrameResult contacts_of(int first, int second) {
  Case c;
  add_element(c, first, 0);
  add_element(c, second, 0.5);
  return run_case(c, settings(Mode::kDcd, Accuracy::kCertified, Scalar::kF64, 0.5));
}

TEST_F(LooseElements, FollowTheTrianglesOfTheirMesh) {
  const Case c = loose_soup(1, 40, 1, 0.2, 0.1);
  const auto detector = Detector::create(spec_for(c, settings(Mode::kCcd, Accuracy::kCandidates)));
  const Topology& topology = detector->topology();
  const Features expected = features_of(c);
  EXPECT_EQ(topology.triangles, expected.triangles);
  EXPECT_EQ(topology.edges, expected.edges);
  std::vector<uint32_t> offsets = {0};
  uint64_t edges = 0, points = 0;
  for (const MeshSpec& mesh : c.meshes) {
    offsets.push_back(offsets.back() + static_cast<uint32_t>(count_elements(mesh)));
    edges += mesh.edges.size(), points += mesh.points.size();
  }
  EXPECT_EQ(topology.triangle_offset, offsets);
  EXPECT_EQ(topology.loose_edges, edges);
  EXPECT_EQ(topology.loose_points, points);
}

// Vertices are numbered first, then those of the second mesh; its element is number 1.
TEST_F(LooseElements, HaveTheContactsOfTheirFeatures) {
  const FrameResult points = contacts_of(1, 1);
  EXPECT_EQ(elements_of(points.vertex_triangle), (Elements{{0, 1}}));
  EXPECT_EQ(points.edge_edge.size(), 0u);
  const FrameResult point_edge = contacts_of(1, 2), edge_point = contacts_of(2, 1);
  EXPECT_EQ(elements_of(point_edge.vertex_triangle), (Elements{{0, 1}}));
  EXPECT_EQ(elements_of(edge_point.vertex_triangle), (Elements{{2, 0}}));
  EXPECT_EQ(point_edge.edge_edge.size() + edge_point.edge_edge.size(), 0u);
  EXPECT_EQ(elements_of(contacts_of(1, 3).vertex_triangle), (Elements{{0, 1}}));
  EXPECT_EQ(elements_of(contacts_of(3, 1).vertex_triangle), (Elements{{3, 0}}));
  const FrameResult edges = contacts_of(2, 2);
  EXPECT_EQ(elements_of(edges.edge_edge), (Elements{{0, 1}}));
  EXPECT_EQ(edges.vertex_triangle.size(), 0u);
  const FrameResult edge_triangle = contacts_of(2, 3);
  EXPECT_EQ(elements_of(edge_triangle.vertex_triangle), (Elements{{0, 1}, {1, 1}}));
  EXPECT_EQ(elements_of(edge_triangle.edge_edge), (Elements{{0, 1}, {0, 2}, {0, 3}}));
}

TEST_F(LooseElements, AreInNoPairOfTriangles) {
  for (const int other : {1, 2, 3}) {
    Case c;
    add_element(c, 3, 0);
    add_element(c, other, 0);
    SceneSpec spec = settings(Mode::kDcd, Accuracy::kExact);
    spec.kinds.triangle_triangle = true;
    EXPECT_EQ(run_case(c, spec).triangle_triangle.size(), other == 3 ? 1u : 0u);
  }
}

/// The contacts of the mesh, that of c.meshes.back(), once with and once without what `repeat` adds to it.
void expect_nothing_added(const Case& c, const std::function<void(MeshSpec&)>& repeat) {
  Case repeated = c;
  repeat(repeated.meshes.back());
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const Accuracy accuracy : {Accuracy::kCandidates, Accuracy::kCertified}) {
      const SceneSpec spec = settings(mode, accuracy, Scalar::kF64, 0.02);
      const FrameResult without = run_case(c, spec);
      EXPECT_GT(count_contacts(without), 20u);
      EXPECT_TRUE(same_contacts(without, run_case(repeated, spec)));
    }
}

TEST_F(LooseElements, AddNothingWhereOthersHaveAllOfThem) {
  const Case mixed = loose_soup(2, 200, 0.5, 0.1, 0.05);
  expect_nothing_added(mixed, [](MeshSpec& particles) {
    particles.points.insert(particles.points.end(), {5, 5, particles.points[0]});
  });
  Case hairs = mixed;
  for (auto* all : {&hairs.start, &hairs.end}) all->pop_back();
  hairs.meshes.pop_back();
  expect_nothing_added(hairs, [](MeshSpec& mesh) {
    mesh.edges.push_back(mesh.edges[3]);
    mesh.edges.push_back({mesh.edges[4][1], mesh.edges[4][0]});
    mesh.points = {mesh.edges[0][0], mesh.edges[5][1]};
  });
  expect_nothing_added(soup(3, 200, 0.5, 0.1, 0.05), [](MeshSpec& mesh) {
    mesh.edges = {{0, 1}, {5, 3}, {1, 0}};
    mesh.points = {0, 4, 8};
  });
}

std::string refused_with(const std::function<void(MeshSpec&)>& change) {
  Case c = loose_soup(4, 10, 1, 0.2, 0.1);
  change(c.meshes[1]);
  return refused_field([&] { Detector::create(spec_for(c, settings(Mode::kCcd, Accuracy::kCertified))); });
}

TEST_F(LooseElements, HaveVerticesOfTheirMesh) {
  EXPECT_EQ("", refused_with([](MeshSpec&) {}));
  EXPECT_EQ("meshes[1].edges[2]", refused_with([](MeshSpec& m) { m.edges[2][1] = m.vertex_count; }));
  EXPECT_EQ("meshes[1].edges[0]", refused_with([](MeshSpec& m) { m.edges[0][0] = ~0u; }));
  EXPECT_EQ("meshes[1].edges[1]", refused_with([](MeshSpec& m) { m.edges[1] = {3, 3}; }));
  EXPECT_EQ("meshes[1].points[1]", refused_with([](MeshSpec& m) { m.points = {0, m.vertex_count}; }));
}

TEST_F(LooseElements, OneIsEnoughForAMesh) {
  EXPECT_EQ("meshes[1].triangles", refused_with([](MeshSpec& m) { m.edges.clear(); }));
  EXPECT_EQ("meshes[1].vertex_count", refused_with([](MeshSpec& m) { m.vertex_count = 0; }));
  Case c;
  add_element(c, 1, 0);
  const SceneSpec spec = settings(Mode::kDcd, Accuracy::kExact, Scalar::kF32, 1);
  EXPECT_EQ(count_contacts(run_case(c, spec)), 0u);
}

// The answer does not depend on which of its kinds are asked for, and a kind alone does not stand for the other.
TEST_F(LooseElements, KindsAreIndependent) {
  const Case c = loose_soup(5, 200, 0.5, 0.1, 0.05);
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF64, 0.02);
  const FrameResult both = run_case(c, spec);
  spec.kinds.edge_edge = false;
  EXPECT_TRUE(same_bytes(both.vertex_triangle, run_case(c, spec).vertex_triangle));
  spec.kinds = {.edge_edge = true};
  EXPECT_TRUE(same_bytes(both.edge_edge, run_case(c, spec).edge_edge));
}

// Points have no length that the spacing of numbers could be compared with; edges do.
TEST_F(LooseElements, PointsSayNothingOfTheResolution) {
  Case particles, hair;
  add_mesh(particles, {}, {{1e6, 0, 0}, {1e6 + 1, 0, 0}, {1e6, 2, 0}});
  particles.meshes[0].points = {0, 1, 2};
  add_mesh(hair, {}, particles.start[0]);
  hair.meshes[0].edges = {{0, 1}, {1, 2}};
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32);
  EXPECT_FALSE(run_case(particles, spec).input_resolution);
  EXPECT_TRUE(run_case(hair, spec).input_resolution);
  hair.meshes[0].points = {0, 0, 0, 0, 0, 0, 0};
  EXPECT_TRUE(run_case(hair, spec).input_resolution) << "points do not outvote what has a length";
}

}  // namespace
}  // namespace collided::test
