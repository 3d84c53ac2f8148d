// The triangles of a scene are counted from the first one until the engine has them.
#include "server/scenes/scene/uploads.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "server/errors.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

class SceneUploadsTest : public testing::Test {
 protected:
  ScenePlan plan_ = tip_plan(1);
  const SceneQuota quota_{plan_};
  SceneRecord record_{{"id", "token", "", 0, client(), 30, 1}, without_elements(plan_)};
  std::unique_ptr<SceneUploads> uploads_ = std::make_unique<SceneUploads>(record_, std::move(plan_.engine), quota_);
};

TEST_F(SceneUploadsTest, WhatHasComeIsHeldByWhoeverHasTheSpec) {
  ReceivedTriangles triangles(quota_.whole);
  triangles.reserve(1);
  triangles.push({0, 1, 2});
  const uint64_t held = quota_.whole->held();
  uploads_->add(1, triangles);
  EXPECT_FALSE(uploads_->awaits_any());
  EXPECT_EQ(quota_.whole->held(), held);
  {
    MemoryHold engine(quota_.whole);
    const SceneSpec spec = uploads_->take_spec(engine);
    EXPECT_EQ(spec.meshes.at(1).triangles.size(), 1u);
    EXPECT_EQ(spec.memory_quota, quota_.of_engine);
    uploads_.reset();
    EXPECT_EQ(quota_.whole->held(), held);
  }
  EXPECT_EQ(quota_.whole->held(), 0u);
}

TEST_F(SceneUploadsTest, ThePlanHasNoTriangles) {
  for (const MeshSpec& mesh : record_.plan()->engine.meshes) EXPECT_TRUE(mesh.triangles.empty());
  MemoryHold engine(quota_.whole);
  EXPECT_EQ(uploads_->take_spec(engine).meshes.at(0).triangles.size(), 1u);
}

TEST_F(SceneUploadsTest, NothingComesOnceTheSceneIsClosed) {
  record_.close({});
  ReceivedTriangles triangles(quota_.whole);
  EXPECT_THROW(uploads_->add(1, triangles), NotFound);
  EXPECT_TRUE(uploads_->awaits_any());
  uploads_->release();
  EXPECT_EQ(quota_.whole->held(), 0u);
}

}  // namespace
}  // namespace collided::server
