// An edit under concurrent readers: a thread that sees its plan can use the plan's meshes.
#include "server/scenes/scene/engine.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <span>
#include <thread>

#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

constexpr uint32_t kFirstAdded = 2, kAdded = 20;

/// An edit that adds a mesh.
PendingFrame adding_frame(uint64_t id, uint32_t mesh, const std::shared_ptr<const ScenePlan>& plan) {
  PendingFrame frame = tip_frame(id, 2);
  SceneEdit edit;
  edit.meshes = {{mesh, {3, {{0, 1, 2}}}}};
  frame.input.edit = std::make_shared<const SceneEdit>(edit);
  frame.input.updates = {{.mesh = mesh, .end = frame.input.updates[1].end}};
  frame.basis = {plan, {{mesh, "copy", false, 1}}};
  return frame;
}

TEST(SceneEngine, AMeshThatIsShownHasItsPlaceInSlotsAndUploads) {
  SceneBench bench;
  const SceneUse scene = bench.add();
  std::atomic<bool> is_over = false;
  std::thread reader([&] {
    const TrianglePositions positions = tip_positions(1);
    while (!is_over) {
      const auto last = static_cast<uint32_t>(scene->plan()->meshes.size() - 1);
      EXPECT_EQ(scene->uploads().awaited(last), 0u);
      const auto slot = scene->engine().take_slot();
      EXPECT_NO_THROW(slot->send({{.mesh = last, .end = std::as_bytes(std::span(positions))}}));
    }
  });
  scene->worker().post([&] {
    EXPECT_NO_THROW(scene->engine().apply(1, tip_frame(1, 2).input));
    for (uint32_t i = 0; i < kAdded; ++i) {
      const PendingFrame frame = adding_frame(2 + i, kFirstAdded + i, scene->plan());
      EXPECT_NO_THROW(scene->engine().apply(frame.frame_id, frame.input, frame.basis));
    }
  });
  scene->worker().flush();
  is_over = true;
  reader.join();
  EXPECT_EQ(scene->plan()->meshes.size(), kFirstAdded + kAdded);
  EXPECT_EQ(scene->record().edits(), kAdded);
}

}  // namespace
}  // namespace collided::server
