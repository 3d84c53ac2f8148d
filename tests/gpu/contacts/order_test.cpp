// Canonical order where a few features have nearly all contacts.

#include <algorithm>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/brute_force.hpp"

namespace collided::test {
namespace {

class CrowdedFeatures : public OnBackend<::testing::TestWithParam<uint32_t>> {
 protected:
  uint32_t count() const { return GetParam(); }

  // One triangle, one corner of which flies through a cloud of small ones.
  Case through_a_cloud() const {
    Case c;
    add_mesh(c, {{0, 1, 2}}, {{-1, -1, -1}, {-3, 0, 0}, {-3, 1, 0}}, {{1, 1, 1}, {-3, 0, 0}, {-3, 1, 0}});
    const Case cloud = soup(250, count(), 1, 0.01, 0.001);
    add_mesh(c, cloud.meshes[0].triangles, cloud.start[0], cloud.end[0]);
    c.meshes[1].self_contacts = false;
    return rounded(c, Scalar::kF32);
  }
};

uint64_t contacts_of_first(const ContactSet& contacts, uint32_t first) {
  return static_cast<uint64_t>(std::count_if(contacts.elements.begin(), contacts.elements.end(),
                                             [&](const auto& pair) { return pair[0] == first; }));
}

TEST_P(CrowdedFeatures, CandidatesAreInOrder) {
  const Case c = through_a_cloud();
  const FrameResult result = run_case(c, settings(Mode::kCcd, Accuracy::kCandidates, Scalar::kF32));
  const ExpectedPairs expected = brute_force(c, Mode::kCcd, Scalar::kF32, 0);
  EXPECT_EQ("", compare(result.vertex_triangle.elements, expected.vertex_triangle));
  EXPECT_EQ("", compare(result.edge_edge.elements, expected.edge_edge));
  EXPECT_EQ(contacts_of_first(result.vertex_triangle, 0), count());
  EXPECT_EQ(contacts_of_first(result.edge_edge, 0), 3 * count());
}

// The small triangles in reverse order.
Case mirrored(Case c) {
  for (Positions* positions : {&c.start[1], &c.end[1]}) {
    std::reverse(positions->begin(), positions->end());
    for (size_t v = 0; v < positions->size(); v += 3) std::swap((*positions)[v], (*positions)[v + 2]);
  }
  return c;
}

// Each contact has its own numbers wherever it ends up: so says the same scene with other ids.
TEST_P(CrowdedFeatures, NumbersStayWithTheirContacts) {
  const Case c = through_a_cloud();
  const SceneSpec spec = settings(Mode::kDcd, Accuracy::kFast, Scalar::kF32, 10);
  const ContactSet found = run_case(c, spec).vertex_triangle, other = run_case(mirrored(c), spec).vertex_triangle;
  const uint32_t n = count();
  ASSERT_EQ(found.size(), 3 * n + 3 * n) << "all are within the distance";
  ASSERT_EQ(other.size(), found.size());
  for (size_t i = 0; i < found.size(); ++i) {
    const auto [vertex, triangle] = found.elements[i];
    ASSERT_TRUE(i == 0 || found.elements[i - 1] < found.elements[i]);
    if (vertex >= 3) break;  // below are the contacts of three crowded vertices, n each
    const size_t twin = size_t{vertex} * n + (n - triangle);
    ASSERT_EQ(other.elements[twin][1], n + 1 - triangle);
    ASSERT_EQ(other.distance[twin], found.distance[i]) << "vertex " << vertex << ", triangle " << triangle;
  }
}

INSTANTIATE_TEST_SUITE_P(Counts, CrowdedFeatures, ::testing::Values(255, 256, 257, 300, 5400));

}  // namespace
}  // namespace collided::test
