// Scenes that know beforehand how long their lists get.

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

/// Far more contacts than triangles.
Case crowded() { return soup(83, 400, 1, 0.6, 0.2); }

SceneSpec octree_settings() {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  spec.engine = Engine::kOctree;
  return spec;
}

struct FirstFrame {
  FrameResult result;
  ListLengths lengths;
};

FirstFrame first_frame(const SceneSpec& settings, const Case& c = crowded()) {
  const auto detector = Detector::create(spec_for(c, settings));
  FrameResult result = detector->detect(Frame(c, settings.mode, settings.scalar).input());
  return {std::move(result), detector->list_lengths()};
}

using ListsThatAreKnown = OnBackend<>;

TEST_F(ListsThatAreKnown, AreMadeOnce) {
  SceneSpec spec = octree_settings();
  spec.known = std::make_shared<KnownLengths>();
  const FirstFrame first = first_frame(spec), second = first_frame(spec);
  EXPECT_GT(first.result.replays, second.result.replays);
  EXPECT_GT(first.result.allocations, second.result.allocations);
  EXPECT_TRUE(same_contacts(first.result, second.result));
}

TEST_F(ListsThatAreKnown, AreThoseOfScenesOfTheSameTrianglesAndOptions) {
  SceneSpec spec = octree_settings();
  spec.known = std::make_shared<KnownLengths>();
  first_frame(spec);
  Case turned = crowded();
  std::swap(turned.meshes[0].triangles[0][0], turned.meshes[0].triangles[0][1]);
  const FirstFrame other = first_frame(spec, turned);
  SceneSpec thicker = spec;
  thicker.thickness = 0.01;
  const FirstFrame thick = first_frame(thicker);
  for (const FirstFrame& frame : {other, thick}) EXPECT_GT(frame.result.replays, first_frame(spec).result.replays);
}

TEST_F(ListsThatAreKnown, GrowWithTheLastSceneThatNeededMore) {
  SceneSpec spec = octree_settings();
  spec.known = std::make_shared<KnownLengths>();
  const Case c = crowded();
  Case apart = c;
  for (size_t i = 0; i < apart.end[0].size(); ++i)
    for (auto* positions : {&apart.start[0], &apart.end[0]}) (*positions)[i][0] += 100.0 * static_cast<double>(i / 3);
  const auto detector = Detector::create(spec_for(c, spec));
  detector->detect(Frame(apart, spec.mode, spec.scalar).input());
  ASSERT_EQ(detector->list_lengths()[ListLengths::kContacts], 0u);
  const FrameResult sudden = detector->detect(Frame(c, spec.mode, spec.scalar).input());
  ASSERT_GT(sudden.replays, 0u);
  EXPECT_EQ(first_frame(spec).lengths[ListLengths::kContacts], detector->list_lengths()[ListLengths::kContacts]);
  EXPECT_LT(first_frame(spec).result.replays, sudden.replays) << "while the other scene is there, and after it";
}

TEST_F(ListsThatAreKnown, OfContactsAloneSpareRoomForThem) {
  SceneSpec spec = octree_settings();
  const FirstFrame without = first_frame(spec);
  spec.expected[ListLengths::kContacts] = without.lengths[ListLengths::kContacts];
  const FirstFrame with = first_frame(spec);
  EXPECT_LT(with.result.allocations, without.result.allocations);
  EXPECT_TRUE(same_contacts(with.result, without.result));
}

TEST_F(ListsThatAreKnown, AreForgottenWhereThereIsNoRoomForThem) {
  SceneSpec spec = octree_settings();
  const FirstFrame without = first_frame(spec);
  for (uint64_t& length : spec.expected.of) length = kMaxListLength;
  spec.memory_budget = 64 << 20;
  EXPECT_TRUE(same_contacts(first_frame(spec).result, without.result));
}

TEST_F(ListsThatAreKnown, AreRefusedBeyondTheLimit) {
  SceneSpec spec = octree_settings();
  spec.expected[ListLengths::kKept] = kMaxListLength + 1;
  try {
    first_frame(spec);
    FAIL() << "refused nothing";
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.field(), "expected");
    EXPECT_STREQ(e.what(), "expected has a list of 4294967296, the limit is 4294967295");
  }
}

TEST(KnownLengthsOfScenes, AreOfThoseThatCameLast) {
  KnownLengths known;
  ListLengths lengths;
  for (uint64_t scene = 0; scene <= KnownLengths::kMost; ++scene) {
    lengths[ListLengths::kLeaves] = scene + 1;
    known.learn(scene, lengths);
    if (scene == KnownLengths::kMost / 2) known.learn(1, lengths);
  }
  EXPECT_FALSE(known.of(0).is_known());
  EXPECT_EQ(known.of(1)[ListLengths::kLeaves], KnownLengths::kMost / 2 + 1);
  EXPECT_EQ(known.of(2)[ListLengths::kLeaves], 3u);
}

}  // namespace
}  // namespace collided::test
