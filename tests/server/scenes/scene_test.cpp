// A resident scene: uploads, frame ids, slots, deletion.
#include "server/scenes/scene.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "server/errors.hpp"
#include "tests/server/scenes/tiny_scene.hpp"
#include "tests/server/wait_until.hpp"

namespace collided::server {
namespace {

class SceneTest : public testing::Test {
 protected:
  // The test's thread plays the worker.
  std::unique_ptr<Scene> make(ScenePlan plan) {
    return std::make_unique<Scene>(SceneIdentity{"id", "token", "", 0, client(), 30, 1}, std::move(plan),
                                   SceneContext{devices_, observer_});
  }
  std::unique_ptr<Scene> make_ready() {
    auto scene = make(tip_plan());
    scene->engine().build_if_complete();
    return scene;
  }

  CountingObserver observer_;
  ServedDevices devices_{std::vector<DeviceTerms>(1)};
};

template <class Error, class Body>
std::string refusal(const Body& body) {
  try {
    body();
  } catch (const Error& e) {
    return e.field() + ": " + e.what();
  }
  return "accepted";
}

void add(Scene& scene, const std::vector<TriangleCorners>& triangles) {
  ReceivedTriangles received(scene.quota());
  received.reserve(triangles.size());
  for (const auto& triangle : triangles) received.push(triangle);
  scene.add_triangles(1, received);
}

/// Holds all turns, so that whoever wants one waits.
class AllTurns {
 public:
  explicit AllTurns(Turns& turns) : accounts_(turns.concurrent()) {
    for (TurnAccount& account : accounts_) held_.push_back(turns.take(account));
  }
  void release() { held_.clear(); }

 private:
  std::vector<TurnAccount> accounts_;
  std::vector<Turns::Turn> held_;  // which end before their accounts
};

// Building takes turns like frames do, but on the host.
TEST_F(SceneTest, IsBuiltInTurnsOfItsClient) {
  Turns& turns = devices_.host_turns();
  AllTurns held(turns);
  const auto scene = make(tip_plan());
  std::thread builder([&] { scene->engine().build_if_complete(); });
  EXPECT_TRUE(wait_until([&] { return turns.waiting() == 1; }));
  EXPECT_FALSE(scene->snapshot().ready);
  held.release();
  builder.join();
  EXPECT_TRUE(scene->snapshot().ready);
}

TEST_F(SceneTest, IsNotBuiltOnceItIsDeleted) {
  Turns& turns = devices_.host_turns();
  const AllTurns held(turns);
  const auto scene = make(tip_plan());
  std::thread builder([&] { EXPECT_THROW(scene->engine().build_if_complete(), NotFound); });
  EXPECT_TRUE(wait_until([&] { return turns.waiting() == 1; }));
  scene->record().close({});
  builder.join();
}

TEST_F(SceneTest, TakesNothingForAMeshThatIsComplete) {
  const auto scene = make(tip_plan(1));
  add(*scene, {{0, 1, 2}});
  ASSERT_TRUE(scene->snapshot().ready);
  EXPECT_THROW(add(*scene, {}), FailedPrecondition);
  EXPECT_THROW(add(*scene, {{0, 1, 2}}), FailedPrecondition);
  EXPECT_TRUE(scene->snapshot().ready);
}

TEST_F(SceneTest, TakesAllTrianglesOfAMeshOrNone) {
  const auto scene = make(tip_plan(1));
  EXPECT_THROW(add(*scene, {}), InvalidInput);
  EXPECT_THROW(add(*scene, {{0, 1, 2}, {0, 1, 2}}), InvalidInput);
  EXPECT_EQ(scene->uploads().awaited(1), 1u);
  EXPECT_FALSE(scene->snapshot().ready);
  add(*scene, {{0, 1, 2}});
  EXPECT_EQ(scene->uploads().awaited(1), 0u);
  EXPECT_TRUE(scene->snapshot().ready);
}

TEST_F(SceneTest, OneUploadOfAMeshAtATime) {
  const auto scene = make(tip_plan(1));
  EXPECT_THROW(scene->uploads().begin(0), FailedPrecondition);
  scene->uploads().begin(1);
  EXPECT_THROW(scene->uploads().begin(1), FailedPrecondition);
  scene->uploads().end(1);
  scene->uploads().begin(1);
}

TEST_F(SceneTest, TrianglesThatMakeNoDetectorLeaveItUnusable) {
  const auto scene = make(tip_plan(1));
  EXPECT_FALSE(scene->unusable());
  const auto why = refusal<InvalidInput>([&] { add(*scene, {{0, 1, 9}}); });
  EXPECT_TRUE(why.starts_with("spec.meshes[1].triangles[0]")) << why;
  EXPECT_TRUE(scene->unusable());
}

TEST_F(SceneTest, AFrameBeforeTheTrianglesIsToldWhatIsAwaited) {
  const auto scene = make(tip_plan(2));
  const std::string rest =
      "scene id takes no frames yet: mesh 1 (\"tip\") awaits 2 of its 2 triangles; send them with UploadMesh";
  EXPECT_EQ(refusal<FailedPrecondition>([&] { scene->engine().apply(1, tip_frame(1, 2).input); }),
            "scene_id: scene_id: " + rest);
  EXPECT_EQ(refusal<FailedPrecondition>([&] { scene->engine().take_slot(); }), "scene_id: scene_id: " + rest);
}

TEST_F(SceneTest, TrianglesAndMeshesCountFromTheStart) {
  auto plan = tip_plan(1);
  plan.engine.memory_budget = 100;
  EXPECT_THROW(make(std::move(plan)), LimitExceeded);
  plan = tip_plan(1);
  plan.meshes.resize(1000, {"", 1, 0});
  plan.engine.meshes.resize(1000, plan.engine.meshes[0]);
  plan.quota = std::make_shared<DeviceBytes>("daemon", "limit", 1 << 20);
  const auto quota = plan.quota;
  {
    const auto scene = make(std::move(plan));
    EXPECT_GT(quota->held(), 1000u * 100);
    EXPECT_EQ(scene->snapshot().memory.at(0).bytes, quota->held());
  }
  EXPECT_EQ(quota->held(), 0u);
}

struct QuietStream final : SceneStream {
  void end(const std::exception_ptr&) override {}
  void announce_stop(double) override {}
  double idle_seconds() const override { return 0; }
  size_t waiting() const override { return 0; }
};

TEST_F(SceneTest, OnlyWhoHasTheTokenTakesAStreamOver) {
  const auto scene = make_ready();
  const auto first = std::make_shared<QuietStream>(), second = std::make_shared<QuietStream>();
  EXPECT_EQ(scene->begin_stream(first, ""), nullptr);
  EXPECT_THROW(scene->begin_stream(second, ""), FailedPrecondition);
  for (const char* const wrong : {"t", "tokem", "Token", "token "})
    EXPECT_THROW(scene->begin_stream(second, wrong), PermissionDenied) << wrong;
  EXPECT_EQ(scene->record().stream(), first);
  EXPECT_EQ(scene->begin_stream(second, "token"), first);
  EXPECT_EQ(scene->record().stream(), second);
}

TEST_F(SceneTest, ASetOfOneIsASet) {
  ScenePlan plan = tip_plan();
  EXPECT_NO_THROW(make(plan)->record().check_is_one("scene_id"));
  plan.engine.worlds = 1;
  EXPECT_THROW(make(plan)->record().check_is_one("scene_id"), FailedPrecondition);
}

TEST_F(SceneTest, AppliesFramesWhoseIdsRiseStrictly) {
  const auto scene = make_ready();
  const auto apply = [&](uint64_t id) { return scene->engine().apply(id, tip_frame(id, 2).input); };
  EXPECT_EQ(refusal<InvalidInput>([&] { apply(0); }), "frame.frame_id: frame.frame_id is 0, but ids start at 1");
  EXPECT_EQ(apply(3).vertex_triangle.size(), 1u);
  for (const uint64_t id : {1, 3}) {
    const auto why = refusal<FailedPrecondition>([&] { apply(id); });
    EXPECT_TRUE(why.starts_with("frame.frame_id: frame.frame_id is " + std::to_string(id))) << why;
  }
  EXPECT_EQ(scene->snapshot().last_frame_id, 3u);
  EXPECT_EQ(apply(~uint64_t{0}).vertex_triangle.size(), 1u);
  EXPECT_THROW(apply(1), FailedPrecondition);
}

TEST_F(SceneTest, ARefusedFrameUsesUpNoId) {
  const auto scene = make_ready();
  const auto why = refusal<InvalidInput>([&] {
    auto frame = tip_frame(1, 2);
    frame.input.updates[1].end = frame.input.updates[1].end.first(12);
    scene->engine().apply(1, frame.input);
  });
  EXPECT_TRUE(why.starts_with("frame.updates[1].positions: frame.updates[1].positions")) << why;
  EXPECT_EQ(scene->snapshot().last_frame_id, 0u);
  scene->engine().apply(1, tip_frame(1, 2).input);
}

TEST_F(SceneTest, ShowsWhatItHolds) {
  const auto scene = make_ready();
  const auto shown = scene->snapshot();
  EXPECT_TRUE(shown.ready && !shown.device.empty() && !shown.memory.empty());
  EXPECT_EQ(shown.vertices, 6u);
  EXPECT_EQ(shown.triangles, 2u);
  EXPECT_EQ(shown.edges, 6u);
  EXPECT_EQ(max_position_bytes(scene->plan()->engine), 6u * 12 * 2);
  EXPECT_TRUE(scene->plan()->engine.meshes[0].triangles.empty());
}

TEST_F(SceneTest, HasNoSlotsBeforeItIsReadyNorOnceItIsDeleted) {
  const auto awaiting = make(tip_plan(1));
  EXPECT_THROW(awaiting->engine().take_slot(), FailedPrecondition);
  const auto scene = make_ready();
  const auto slot = scene->engine().take_slot();
  EXPECT_GE(slot->room(100).size(), 100u);
  scene->record().close({});
  scene->release();
  EXPECT_THROW(scene->engine().take_slot(), NotFound);
  EXPECT_THROW(scene->engine().apply(1, tip_frame(1, 2).input), NotFound);
  EXPECT_THROW(scene->record().check_open(), NotFound);
}

TEST_F(SceneTest, ASlotBringsPositions) {
  const auto scene = make_ready();
  auto frame = tip_frame(1, 2);
  FrameInput input;
  input.slot = scene->engine().take_slot();
  input.slot->send(frame.input.updates);
  EXPECT_EQ(scene->engine().apply(1, input).vertex_triangle.size(), 1u);
}

/// An edit that adds a copy of the tip.
PendingFrame adding_frame(uint64_t id, const std::shared_ptr<const ScenePlan>& plan) {
  PendingFrame frame = tip_frame(id, 2);
  SceneEdit edit;
  edit.meshes = {{2, {3, {{0, 1, 2}}}}};
  frame.input.edit = std::make_shared<const SceneEdit>(edit);
  frame.input.updates = {{.mesh = 2, .end = frame.input.updates[1].end}};
  frame.basis = {plan, {{2, "copy", false, 1}}};
  return frame;
}

TEST_F(SceneTest, FollowsItsEdits) {
  const auto scene = make_ready();
  scene->engine().apply(1, tip_frame(1, 2).input);
  const auto before = scene->plan();
  const uint64_t bytes_before = max_position_bytes(scene->plan()->engine);
  const PendingFrame frame = adding_frame(2, before);
  scene->engine().apply(2, frame.input, frame.basis);
  const auto after = scene->plan();
  ASSERT_EQ(after->meshes.size(), 3u);
  EXPECT_EQ(after->meshes[2].name, "copy");
  EXPECT_EQ(after->meshes[2].triangles, 1u);
  EXPECT_EQ(before->meshes.size(), 2u);
  EXPECT_EQ(scene->snapshot().vertices, 9u);
  EXPECT_EQ(scene->snapshot().triangles, 3u);
  EXPECT_EQ(scene->record().edits(), 1u);
  EXPECT_EQ(max_position_bytes(scene->plan()->engine), bytes_before / 2 * 3);
  EXPECT_EQ(scene->uploads().awaited(2), 0u);
  EXPECT_THROW(scene->uploads().begin(2), FailedPrecondition);
}

// It was checked against another scene than the one that it would be applied to.
TEST_F(SceneTest, RefusesWhatWasCheckedBeforeAnEdit) {
  const auto scene = make_ready();
  scene->engine().apply(1, tip_frame(1, 2).input);
  const auto before = scene->plan();
  const auto slot = scene->engine().take_slot();
  const PendingFrame edit = adding_frame(2, before), other = adding_frame(3, before);
  scene->engine().apply(2, edit.input, edit.basis);
  EXPECT_EQ(refusal<FailedPrecondition>([&] { scene->engine().apply(3, other.input, other.basis); }),
            "frame: frame 3 came before scene id was edited by frame 2, and does not fit it any more; send it again");
  FrameInput of_slot;
  slot->send({});
  of_slot.slot = slot;
  EXPECT_EQ(refusal<FailedPrecondition>([&] { scene->engine().apply(3, of_slot); }).substr(0, 6), "frame:");
  EXPECT_EQ(scene->record().edits(), 1u);
  scene->engine().apply(3, tip_frame(3, 2).input);
}

// Memory of its tables is taken before the engine begins, so that no frame fails once it has been applied.
TEST_F(SceneTest, AnEditThatTheClientHasNoMemoryForChangesNothing) {
  ScenePlan plan = tip_plan();
  plan.engine.memory_budget = 600'000;
  const auto scene = make(std::move(plan));
  scene->engine().build_if_complete();
  scene->engine().apply(1, tip_frame(1, 2).input);
  PendingFrame frame = adding_frame(2, scene->plan());
  SceneEdit huge = *frame.input.edit;
  huge.meshes[0].spec.triangles.assign(20'000, {0, 1, 2});
  frame.input.edit = std::make_shared<const SceneEdit>(huge);
  EXPECT_THROW(scene->engine().apply(2, frame.input, frame.basis), LimitExceeded);
  EXPECT_EQ(scene->record().edits(), 0u);
  EXPECT_EQ(scene->engine().apply(2, tip_frame(2, 2).input).vertex_triangle.size(), 1u);
}

}  // namespace
}  // namespace collided::server
