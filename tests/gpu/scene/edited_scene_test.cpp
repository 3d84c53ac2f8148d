// What an edit may be, what it leaves alone, and what it costs.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/counted_quota.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 6;

Positions sheet_at(double x, double z) {
  return grid(kSide, [&](double i, double j) { return Vec3d{x + i, j, z + 0.01 * std::sin(i + 2 * j)}; });
}
/// Sheets that lie on each other, the first of them static.
Case stack(uint32_t sheets) {
  Case c;
  for (uint32_t m = 0; m < sheets; ++m)
    add_mesh(c, grid_triangles(kSide), sheet_at(0.3 * m, 0.2 * m), sheet_at(0.3 * m, 0.15 * m), m == 0);
  c.end[0] = c.start[0];
  return c;
}

FrameInput with_edit(FrameInput input, SceneEdit edit) {
  input.edit = std::make_shared<const SceneEdit>(std::move(edit));
  return input;
}
MeshSpec sheet() { return {kSide * kSide, grid_triangles(kSide)}; }

class EditedScene : public OnBackend<::testing::TestWithParam<Mode>> {
 protected:
  EditedScene() : case_(stack(3)), first_(case_, GetParam(), Scalar::kF64) {
    spec_ = spec_for(case_, settings(GetParam(), Accuracy::kCertified, Scalar::kF64, 0.3));
    spec_.fields = kEveryField;
  }
  std::unique_ptr<Detector> begun() const {
    auto detector = Detector::create(spec_);
    detector->detect(first_.input());
    return detector;
  }
  /// What a new scene of such meshes says of a frame whose positions are all given.
  FrameResult anew(const Case& c, SceneSpec spec) const {
    spec.meshes = c.meshes;
    return Detector::create(spec)->detect(Frame(c, spec.mode, spec.scalar).input());
  }

  const Case case_;
  const Frame first_;
  SceneSpec spec_;
};

// The frames name every mesh, so that a new scene knows as much.
TEST_P(EditedScene, AnswersAsANewOneByEveryEngine) {
  Case torn = case_;
  torn.meshes[1].vertex_count += 1;
  torn.meshes[1].triangles[3][1] = kSide * kSide;
  for (auto* positions : {&torn.start[1], &torn.end[1]})
    positions->push_back((*positions)[torn.meshes[1].triangles[2][1]]);
  add_mesh(torn, grid_triangles(kSide), sheet_at(1, 0.7), sheet_at(1, 0.4));
  const Frame frame(torn, spec_.mode, spec_.scalar, false);
  for (const Engine engine : {Engine::kOctree, Engine::kTopDown, Engine::kUniformGrid, Engine::kLbvh, Engine::kVss,
                              Engine::kAllPairs}) {
    spec_.engine = engine;
    const auto detector = begun();
    const FrameResult found =
        detector->detect(with_edit(frame.input(), {.meshes = {{1, torn.meshes[1]}, {3, torn.meshes[3]}}}));
    const FrameResult expected = anew(torn, spec_);
    EXPECT_GT(count_contacts(found), 100u);
    EXPECT_TRUE(same_contacts(found, expected));
    EXPECT_EQ(found.earliest_toi, expected.earliest_toi);
    EXPECT_EQ(detector->spec().meshes[1].vertex_count, kSide * kSide + 1);
    EXPECT_EQ(detector->topology().triangle_offset.size(), 5u);
  }
}

TEST_P(EditedScene, HasAStageOfItsOwn) {
  const auto detector = begun();
  const auto has_stage = [](const FrameResult& result) {
    return std::any_of(result.stages.begin(), result.stages.end(), [](const auto& s) { return s.stage == "edit"; });
  };
  FrameInput still;
  EXPECT_TRUE(has_stage(detector->detect(with_edit(still, {.excluded = {{1, 2}}}))));
  EXPECT_FALSE(has_stage(detector->detect(still)));
}

// The vertices of a mesh whose triangles alone change stay where they are.
TEST_P(EditedScene, KeepsPositionsWhereItCan) {
  const auto detector = begun();
  MeshSpec fewer = sheet();
  fewer.triangles.resize(fewer.triangles.size() / 2);
  const FrameResult found = detector->detect(with_edit({}, {.meshes = {{2, fewer}}}));
  Case still = case_;
  still.meshes[2].triangles = fewer.triangles;
  still.start = still.end;
  EXPECT_TRUE(same_contacts(found, anew(still, spec_)));
}

// Groups, masks, rings and pairs change without a word of triangles or positions.
TEST_P(EditedScene, ChangesWhoMayTouchWhomAlone) {
  const auto detector = begun();
  MeshSpec rules = sheet();
  rules.triangles.clear();
  rules.self_contacts = false;
  rules.groups = 2;
  detector->detect(with_edit({}, {.meshes = {{2, rules}}, .excluded = {{1, 0}}}));
  const FrameResult found = detector->detect({});
  Case still = case_;
  still.start = still.end;
  still.meshes[2].self_contacts = false;
  still.meshes[2].groups = 2;
  SceneSpec spec = spec_;
  spec.excluded_meshes = {{0, 1}};
  EXPECT_TRUE(same_contacts(found, anew(still, spec)));
  detector->detect(with_edit({}, {.included = {{0, 1}}}));
  EXPECT_TRUE(same_contacts(detector->detect({}), anew(still, spec_)));
}

// A mesh that is removed has no contacts and takes no positions; its number can be filled again.
TEST_P(EditedScene, CanLoseAMeshAndGetItBack) {
  const auto detector = begun();
  const FrameResult two = detector->detect(with_edit({}, {.meshes = {{1, {}}}}));
  Case still = case_;
  still.start = still.end;
  Case left = still;
  left.meshes.erase(left.meshes.begin() + 1), left.start.erase(left.start.begin() + 1),
      left.end.erase(left.end.begin() + 1);
  EXPECT_TRUE(same_contacts(two, anew(left, spec_)));
  const auto bytes = pack(case_.end[1], spec_.scalar);
  FrameInput of_removed{.updates = {{1, {}, bytes}}};
  EXPECT_EQ("updates[0].mesh", refused_field([&] { detector->detect(of_removed); }));
  EXPECT_TRUE(same_contacts(detector->detect(with_edit(of_removed, {.meshes = {{1, sheet()}}})), anew(still, spec_)));
}

// Static meshes may be put elsewhere; a rigid one keeps its pose, and its first positions, beside all edits of others.
TEST_P(EditedScene, LeavesRigidMeshesWhereTheyAre) {
  spec_.meshes[2].motion = MeshMotion::kRigid;
  const auto turned = [](double angle) {
    const double c = std::cos(angle), sine = std::sin(angle);
    const double rows[12] = {c, -sine, 0, 0.1, sine, c, 0, 0, 0, 0, 1, 0.05};
    const auto* bytes = reinterpret_cast<const std::byte*>(rows);
    return OwnedUpdate{.mesh = 2, .transform = {bytes, bytes + sizeof(rows)}};
  };
  std::vector<OwnedUpdate> first;
  for (uint32_t m = 0; m < 3; ++m) first.push_back({.mesh = m, .end = pack(case_.end[m], spec_.scalar)});
  const std::vector<OwnedUpdate> turn{turned(0.2)}, later{turned(0.3)};
  const auto plain = Detector::create(spec_), edited = Detector::create(spec_);
  for (Detector* detector : {plain.get(), edited.get()}) {
    detector->detect(frame_of(first));
    detector->detect(frame_of(turn));
  }
  Case far;
  add_mesh(far, grid_triangles(kSide), sheet_at(100, 100));
  const std::vector<OwnedUpdate> added{later[0], {.mesh = 3, .end = pack(far.end[0], spec_.scalar)}};
  const FrameInput input = with_edit(frame_of(added), {.meshes = {{3, far.meshes[0]}}});
  const FrameResult expected = plain->detect(frame_of(later)), found = edited->detect(input);
  EXPECT_GT(count_contacts(found), 100u);
  // The far sheet's features come last, so that the others have the ids that they had; it touches nothing.
  EXPECT_TRUE(same_contacts(expected, found));
}

TEST_P(EditedScene, CanAdvance) {
  if (GetParam() == Mode::kDcd) GTEST_SKIP() << "advances are of CCD";
  spec_.thickness = 0;
  const auto detector = begun();
  Case c;
  add_mesh(c, grid_triangles(kSide), sheet_at(0.5, 2), sheet_at(0.5, -2));
  const std::vector<OwnedUpdate> updates{
      {.mesh = 3, .start = pack(c.start[0], spec_.scalar), .end = pack(c.end[0], spec_.scalar)}};
  FrameInput input = with_edit(frame_of(updates), {.meshes = {{3, sheet()}}});
  input.advance = true;
  const FrameResult result = detector->detect(input);
  ASSERT_TRUE(result.advanced.has_value());
  EXPECT_GT(*result.advanced, 0.3);
  EXPECT_LT(*result.advanced, 0.6);
}

TEST_P(EditedScene, RefusesWhatItCannotBe) {
  const auto detector = begun();
  const auto refused = [&](SceneEdit edit, FrameInput input = {}) {
    return refused_field([&] { detector->detect(with_edit(std::move(input), std::move(edit))); });
  };
  MeshSpec bad_index = sheet(), twice = sheet(), no_vertices = sheet(), rings = sheet(), other_count = sheet();
  bad_index.triangles[5] = {0, 1, kSide * kSide};
  twice.triangles[5] = {0, 1, 1};
  no_vertices.vertex_count = 0;
  rings.excluded_rings = kMaxRings + 1;
  other_count.triangles.clear();
  ++other_count.vertex_count;
  EXPECT_EQ("edit.meshes[0].mesh", refused({.meshes = {{5, sheet()}}}));
  EXPECT_EQ("edit.meshes[1].mesh", refused({.meshes = {{1, sheet()}, {1, sheet()}}}));
  EXPECT_EQ("edit.meshes[0]", refused({.meshes = {{3, {}}}}));
  EXPECT_EQ("meshes[1].triangles[5]", refused({.meshes = {{1, bad_index}}}));
  EXPECT_EQ("meshes[1].triangles[5]", refused({.meshes = {{1, twice}}}));
  EXPECT_EQ("edit.meshes[0].spec.vertex_count", refused({.meshes = {{1, no_vertices}}}));
  EXPECT_EQ("edit.meshes[0].spec.excluded_rings", refused({.meshes = {{1, rings}}}));
  EXPECT_EQ("edit.meshes[0].spec.triangles", refused({.meshes = {{1, other_count}}}));
  EXPECT_EQ("edit.meshes", refused({.meshes = {{0, {}}, {1, {}}, {2, {}}}}));
  EXPECT_EQ("edit.excluded[1]", refused({.excluded = {{0, 1}, {1, 0}}}));
  EXPECT_EQ("edit.excluded[0]", refused({.excluded = {{0, 3}}}));
  EXPECT_EQ("edit.excluded[0]", refused({.meshes = {{1, {}}}, .excluded = {{0, 1}}}));
  EXPECT_EQ("edit.included[0]", refused({.included = {{0, 1}}}));
  EXPECT_EQ("rest_distance", refused({.rest_distance = std::numeric_limits<double>::infinity()}));
  EXPECT_EQ("updates", refused({.meshes = {{3, sheet()}}}));  // its positions are missing
  FrameInput trial, fraction, by_slot;
  trial.trial = true;
  by_slot.slot = detector->make_slot();
  EXPECT_EQ("edit", refused({}, trial));
  EXPECT_EQ("slot", refused({}, by_slot));
  if (GetParam() == Mode::kCcd) {
    fraction.start_fraction = 0.5;
    EXPECT_EQ("edit", refused({}, fraction));
    detector->detect(with_edit({}, {.excluded = {{1, 2}}}));
    EXPECT_EQ("", refused_field([&] { detector->detect(fraction); }));  // the edit's frame has a way of its own
    detector->detect(with_edit({}, {.included = {{1, 2}}}));
  }
  Case still = case_;
  still.start = still.end;
  EXPECT_TRUE(same_contacts(detector->detect({}), anew(still, spec_)));
}

// Where vertices begin that were not there is nothing to guess.
TEST_P(EditedScene, AsksWhereTheVerticesOfATornMeshBegin) {
  const auto detector = begun();
  MeshSpec more = sheet();
  ++more.vertex_count;
  Positions positions = case_.end[1];
  positions.push_back({9, 9, 9});
  const auto bytes = pack(positions, spec_.scalar);
  const FrameInput without_start{.updates = {{1, {}, bytes}}};
  const std::string field = refused_field([&] { detector->detect(with_edit(without_start, {.meshes = {{1, more}}})); });
  EXPECT_EQ(GetParam() == Mode::kCcd ? "updates[0].start" : "", field);
}

TEST_P(EditedScene, TheFirstFrameHasNone) {
  const auto detector = Detector::create(spec_);
  EXPECT_EQ("edit", refused_field([&] { detector->detect(with_edit(first_.input(), {.excluded = {{1, 2}}})); }));
  EXPECT_EQ("", refused_field([&] { detector->detect(first_.input()); }));
}

TEST_P(EditedScene, SlotsAreOfTheSceneBeforeOrAfter) {
  const auto detector = begun();
  const auto before = detector->make_slot();
  const Frame still(case_, spec_.mode, spec_.scalar, false);
  before->send(still.input().updates);
  detector->detect(with_edit({}, {.meshes = {{1, {}}}}));
  FrameInput input;
  input.slot = before;
  EXPECT_EQ("slot", refused_field([&] { detector->detect(input); }));
  input.slot = detector->make_slot();
  const auto bytes = pack(case_.end[2], spec_.scalar);
  input.slot->send({{2, {}, bytes}});
  EXPECT_EQ("", refused_field([&] { detector->detect(input); }));
}

uint64_t bytes_held(const Detector& detector) {
  uint64_t bytes = 0;
  for (const MemoryPart& part : detector.memory()) bytes += part.bytes;
  return bytes;
}

// A scene that shrinks gives back what it no longer needs; one whose edit does not fit stays what it was.
TEST_P(EditedScene, HoldsWhatItIsNow) {
  const auto quota = std::make_shared<CountedQuota>();
  spec_.memory_quota = quota;
  spec_.memory_budget = 32u << 20;
  const auto detector = begun();
  const uint64_t small = bytes_held(*detector);
  const auto grow_to = [&](uint32_t side) {
    const auto bytes = pack(flat_grid(side, 3), spec_.scalar);
    return detector->detect(
        with_edit({.updates = {{3, {}, bytes}}}, {.meshes = {{3, {side * side, grid_triangles(side)}}}}));
  };
  EXPECT_THROW(grow_to(400), ResourceExhausted);
  const uint64_t after_failure = bytes_held(*detector);
  Case still = case_;
  still.start = still.end;
  EXPECT_TRUE(same_contacts(detector->detect({}), anew(still, spec_)));
  grow_to(60);
  const uint64_t large = bytes_held(*detector);
  detector->detect(with_edit({}, {.meshes = {{3, {}}}}));
  EXPECT_TRUE(same_contacts(detector->detect({}), anew(still, spec_)));
  EXPECT_GT(large, 3 * small);
  EXPECT_LT(bytes_held(*detector), 2 * small);
  EXPECT_LT(after_failure, large);
}

INSTANTIATE_TEST_SUITE_P(Modes, EditedScene, ::testing::Values(Mode::kDcd, Mode::kCcd),
                         [](const auto& info) { return info.param == Mode::kCcd ? "Ccd" : "Dcd"; });

}  // namespace
}  // namespace collided::test
