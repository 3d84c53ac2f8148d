// Contacts that are told to come no closer, against exact arithmetic.

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/distance.hpp"

namespace collided::test {
namespace {

using Separating = OnBackend<>;

size_t count_separating(const ContactSet& contacts) {
  size_t count = 0;
  for (const uint8_t flags : contacts.flags) count += (flags & kFlagSeparating) != 0 ? 1 : 0;
  return count;
}

/// Of those with the flag, in exact arithmetic: the ones that come closer than they may.
size_t count_wrong(const Case& c, const ContactSet& contacts, QueryKind kind) {
  const CaseQueries queries(c);
  size_t wrong = 0;
  for (size_t i = 0; i < contacts.size(); ++i) {
    if ((contacts.flags[i] & kFlagSeparating) == 0) continue;
    EXPECT_EQ(0, contacts.toi[i]);
    const Query query = queries.of_pair(kind, key_of(contacts.elements[i][0], contacts.elements[i][1]));
    // Distances as doubles are within 1e-9 of the truth: these features are not much smaller than their coordinates.
    const double kept = contacts.distance[i] * (1 - 0x1p-20 - 1e-9);
    wrong += judge_ccd(query, kept).hit ? 1 : 0;
  }
  return wrong;
}

TEST_F(Separating, NothingThatIsFlaggedComesCloser) {
  size_t flagged = 0;
  for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
    for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact})
      for (uint32_t seed = 1; seed <= 4; ++seed) {
        const Case c = rounded(soup(seed, 120, 1, 0.25, 0.02 * seed), scalar);
        const FrameResult found = run_case(c, settings(Mode::kCcd, accuracy, scalar, 0.05));
        flagged += count_separating(found.vertex_triangle) + count_separating(found.edge_edge);
        EXPECT_EQ(0u, count_wrong(c, found.vertex_triangle, QueryKind::kVertexTriangle));
        EXPECT_EQ(0u, count_wrong(c, found.edge_edge, QueryKind::kEdgeEdge));
      }
  EXPECT_GT(flagged, 100u);
}

/// Two triangles, one above the other by 1/64, that end `by` farther apart and are shifted sideways.
Case over_each_other(double by) {
  const Positions low{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  Positions high = low, end = low;
  for (size_t i = 0; i < 3; ++i) {
    high[i] = {low[i][0] + 0.125, low[i][1] + 0.125, 1.0 / 64};
    end[i] = {high[i][0], high[i][1], high[i][2] + by};
  }
  Case c;
  add_mesh(c, {{0, 1, 2}}, low, low);
  add_mesh(c, {{0, 1, 2}}, high, end);
  return c;
}

TEST_F(Separating, RestAndPartingAreToldFromComingCloser) {
  for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
    for (const double by : {0.0, 0.25, -1.0 / 256}) {
      const Case c = over_each_other(by);
      const FrameResult found = run_case(c, settings(Mode::kCcd, Accuracy::kCertified, scalar, 1.0 / 32));
      const size_t contacts = found.vertex_triangle.size() + found.edge_edge.size();
      ASSERT_GT(contacts, 0u);
      EXPECT_EQ(by < 0 ? 0 : contacts, count_separating(found.vertex_triangle) + count_separating(found.edge_edge))
          << by;
    }
}

TEST_F(Separating, ReportsLeaveThemOutWhenAsked) {
  const Case c = over_each_other(0.25);
  for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact})
    for (const Report report : {Report::kAll, Report::kEarliestOnly, Report::kAnyHit})
      for (const bool ignored : {false, true}) {
        const SceneSpec spec = settings(Mode::kCcd, accuracy, Scalar::kF64, 1.0 / 32);
        const Frame frame(c, Mode::kCcd, Scalar::kF64);
        FrameInput input = frame.input();
        input.report = report;
        input.ignore_separating = ignored;
        const FrameResult found = Detector::create(spec_for(c, spec))->detect(input);
        EXPECT_EQ(ignored || report == Report::kAnyHit ? 1 : 0, found.earliest_toi);
        EXPECT_EQ(!ignored || report == Report::kAll, found.any_contact);
      }
}

}  // namespace
}  // namespace collided::test
