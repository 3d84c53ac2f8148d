// Uploaded triangles on their way into a scene.
#include "server/scenes/scene.hpp"

#include <gtest/gtest.h>

#include "server/errors.hpp"

namespace collided::server {
namespace {

// One mesh of six vertices that awaits two triangles.
ScenePlan awaiting_plan() {
  ScenePlan plan;
  plan.meshes = {{"cloth", 2}};
  plan.engine.meshes.resize(1);
  plan.engine.meshes[0].vertex_count = 6;
  plan.engine.memory_budget = 1 << 30;
  return plan;
}

TEST(Scene, TakesNothingForAMeshThatIsComplete) {
  Scene scene("id", awaiting_plan(), 1);
  scene.add_triangles(0, {{0, 1, 2}, {3, 4, 5}});
  ASSERT_TRUE(scene.snapshot().ready);
  EXPECT_THROW(scene.add_triangles(0, {}), FailedPrecondition);
  EXPECT_THROW(scene.add_triangles(0, {{0, 1, 2}}), FailedPrecondition);
  EXPECT_TRUE(scene.snapshot().ready);
}

TEST(Scene, TakesAllTrianglesOfAMeshOrNone) {
  Scene scene("id", awaiting_plan(), 1);
  EXPECT_THROW(scene.add_triangles(0, {}), InvalidInput);
  EXPECT_THROW(scene.add_triangles(0, {{0, 1, 2}}), InvalidInput);
  EXPECT_EQ(scene.awaited(0), 2u);
  scene.add_triangles(0, {{0, 1, 2}, {3, 4, 5}});
  EXPECT_EQ(scene.awaited(0), 0u);
  EXPECT_TRUE(scene.snapshot().ready);
}

}  // namespace
}  // namespace collided::server
