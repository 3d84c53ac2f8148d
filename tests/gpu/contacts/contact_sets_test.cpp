// What is done with contacts on the host.

#include "gpu/step/contact_sets.hpp"

#include <gtest/gtest.h>

namespace collided::test {
namespace {

constexpr uint8_t kSure = kFlagCertified, kSureInitial = kFlagCertified | kFlagInitial;

CpuLoops loops(1);

// Contacts (i, i + 100) with all arrays, entry i marked by i in each.
ContactSet contacts(const std::vector<double>& toi, const std::vector<uint8_t>& flags) {
  std::vector<std::array<uint32_t, 2>> elements;
  std::vector<double> distance;
  std::vector<std::array<double, 2>> weights;
  std::vector<Normal> normals;
  for (uint32_t i = 0; i < toi.size(); ++i) {
    elements.push_back({i, i + 100});
    distance.push_back(i);
    weights.push_back({0.5 * i, 0.25 * i});
    normals.push_back({1.0f * i, 0, 0});
  }
  ContactSet set;
  set.elements = elements;
  set.distance = distance;
  set.weights = weights;
  set.normals = normals;
  set.toi = toi;
  set.flags = flags;
  return set;
}

std::vector<size_t> undecided_places(const ContactSet& set) {
  return undecided(loops, set, count_undecided(loops, set));
}

// What contacts() marked with these numbers.
void expect_are(const ContactSet& set, const std::vector<uint32_t>& marks) {
  ASSERT_EQ(set.size(), marks.size());
  ASSERT_EQ(set.toi.size(), marks.size());
  ASSERT_EQ(set.distance.size(), marks.size());
  ASSERT_EQ(set.weights.size(), marks.size());
  ASSERT_EQ(set.normals.size(), marks.size());
  ASSERT_EQ(set.flags.size(), marks.size());
  for (size_t i = 0; i < marks.size(); ++i) {
    EXPECT_EQ(set.elements[i], (std::array<uint32_t, 2>{marks[i], marks[i] + 100}));
    EXPECT_EQ(set.distance[i], marks[i]);
    EXPECT_EQ(set.weights[i], (std::array<double, 2>{0.5 * marks[i], 0.25 * marks[i]}));
  }
}

TEST(ContactSets, UndecidedIsWhatIsNotCertainOrMayNotBeAtTimeZero) {
  const ContactSet set =
      contacts({0.5, 0.5, 0, 0, 1}, {kSure, kFlagNear, kSure, kSureInitial, kFlagNear | kFlagCapped});
  EXPECT_EQ(undecided_places(set), (std::vector<size_t>{1, 2, 4}));
}

TEST(ContactSets, WithoutTimesOnlyCertaintyDecides) {
  ContactSet set = contacts({0, 0, 0}, {kSure, kFlagNear, kSure});
  set.toi = {};
  EXPECT_EQ(undecided_places(set), (std::vector<size_t>{1}));
}

TEST(ContactSets, NothingIsUndecidedInAnEmptySet) { EXPECT_TRUE(undecided_places({}).empty()); }

TEST(ContactSets, AnswersSetTimesAndFlagsAndRemoveWhatIsNoContact) {
  ContactSet set = contacts({0.1, 0.2, 0, 0.4}, {kFlagNear, kFlagNear | kFlagCapped, kFlagNear | kFlagInitial, kSure});
  apply(loops, set, {0, 1, 2}, {{false, 0, false}, {true, 0.25, false}, {true, 0, true}}, {{}, {0, 1, 0}, {0, 0, 1}});
  expect_are(set, {1, 2, 3});
  EXPECT_EQ(set.normals, (Column<Normal>{{0, 1, 0}, {0, 0, 1}, {3, 0, 0}}));
  EXPECT_EQ(set.toi, (Column<double>{0.25, 0, 0.4}));
  EXPECT_EQ(set.flags, (Column<uint8_t>{kSure, kSureInitial, kSure}));
}

TEST(ContactSets, EveryContactMayGo) {
  ContactSet set = contacts({0.1, 0.2}, {kFlagNear, kFlagNear});
  apply(loops, set, {0, 1}, {{}, {}}, {{}, {}});
  expect_are(set, {});
}

TEST(ContactSets, ArraysThatAreNotThereStayEmpty) {
  ContactSet set;
  set.elements = {{1, 2}, {3, 4}};
  set.flags = {kFlagNear, kFlagNear};
  apply(loops, set, {0, 1}, {{false, 0, false}, {true, 0, false}}, {});
  EXPECT_EQ(set.elements, (Column<std::array<uint32_t, 2>>{{3, 4}}));
  EXPECT_EQ(set.flags, (Column<uint8_t>{kSure}));
  EXPECT_TRUE(set.toi.empty() && set.distance.empty() && set.weights.empty());
}

// The one that keep_earliest() leaves of contacts with these times: its mark in each kind, or none.
std::array<std::vector<uint32_t>, 2> kept(const std::vector<double>& vt, const std::vector<double>& ee) {
  FrameResult result;
  result.vertex_triangle = contacts(vt, std::vector<uint8_t>(vt.size(), kSure));
  result.edge_edge = contacts(ee, std::vector<uint8_t>(ee.size(), kSure));
  keep_earliest(loops, result);
  std::array<std::vector<uint32_t>, 2> marks;
  for (const auto& e : result.vertex_triangle.elements) marks[0].push_back(e[0]);
  for (const auto& e : result.edge_edge.elements) marks[1].push_back(e[0]);
  expect_are(result.vertex_triangle, marks[0]);
  expect_are(result.edge_edge, marks[1]);
  return marks;
}

TEST(ContactSets, KeepsTheEarliestOfBothKinds) {
  using Kept = std::array<std::vector<uint32_t>, 2>;
  EXPECT_EQ(kept({0.5, 0.25, 0.75}, {0.5}), (Kept{{{1}, {}}}));
  EXPECT_EQ(kept({0.5}, {0.5, 0.75, 0.125}), (Kept{{{}, {2}}}));
  EXPECT_EQ(kept({0.5}, {}), (Kept{{{0}, {}}}));
  EXPECT_EQ(kept({}, {0.5}), (Kept{{{}, {0}}}));
  EXPECT_EQ(kept({}, {}), (Kept{}));
}

TEST(ContactSets, OfSeveralEarliestVertexTriangleComesFirstThenTheLowestIds) {
  using Kept = std::array<std::vector<uint32_t>, 2>;
  EXPECT_EQ(kept({0.5, 0.25, 0.25}, {0.25}), (Kept{{{1}, {}}}));
  EXPECT_EQ(kept({0.5}, {0.25, 0.25}), (Kept{{{}, {0}}}));
}

TEST(ContactSets, EarliestTimeIsOneWithoutContacts) {
  EXPECT_EQ(earliest_toi(loops, {}, false), 1);
  const ContactSet some = contacts({0.5, 0.25, 0.75}, {kSure, kSure, kSure}), later = contacts({0.5}, {kSure});
  EXPECT_EQ(earliest_toi(loops, {.vertex_triangle = some, .edge_edge = later}, false), 0.25);
  EXPECT_EQ(earliest_toi(loops, {.vertex_triangle = later, .edge_edge = some}, false), 0.25);
  for (size_t place = 0; place < 40; ++place) {
    std::vector<double> toi(40, 0.5);
    toi[place] = 0.125;
    const ContactSet one = contacts(toi, std::vector<uint8_t>(40, kSure));
    EXPECT_EQ(earliest_toi(loops, {.vertex_triangle = one, .edge_edge = {}}, false), 0.125) << place;
  }
}

TEST(ContactSets, EarliestTimeMayLeaveOutWhatSeparates) {
  const ContactSet some = contacts({0, 0.25, 0.75}, {kSure | kFlagSeparating, kSure, kSure});
  EXPECT_EQ(earliest_toi(loops, {.vertex_triangle = some}, false), 0);
  EXPECT_EQ(earliest_toi(loops, {.vertex_triangle = some}, true), 0.25);
  const ContactSet all = contacts({0, 0}, {kSure | kFlagSeparating, kSure | kFlagSeparating});
  EXPECT_EQ(earliest_toi(loops, {.edge_edge = all}, true), 1);
}

}  // namespace
}  // namespace collided::test
