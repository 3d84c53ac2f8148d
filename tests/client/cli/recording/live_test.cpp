#include "client/cli/recording/live.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "client/cli/recording/meshes.hpp"
#include "client/cli/recording/reader.hpp"

namespace collided::cli {
namespace {

namespace fs = std::filesystem;

/// A triangle and a static one.
v1::Scene scene_of_two() {
  v1::Scene scene;
  scene.set_vertex_count(6);
  v1::SceneSpec& spec = *scene.mutable_spec();
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F32);
  for (const char* name : {"cloth", "floor"}) {
    v1::MeshSpec& mesh = *spec.add_meshes();
    mesh.set_name(name);
    mesh.set_vertex_count(3);
    mesh.set_triangle_count(1);
  }
  spec.mutable_meshes(1)->set_motion(v1::MESH_MOTION_STATIC);
  return scene;
}

class LiveRecorderTest : public ::testing::Test {
 protected:
  LiveRecorderTest() : folder_(fs::temp_directory_path() / ("live_test_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~LiveRecorderTest() override { fs::remove_all(folder_); }

  std::string put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::string recording() const { return (folder_ / "live.rec").string(); }
  std::string both() const {
    return put("both.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\nf 4 6 5\n");
  }

  static client::WatchedFrame frame(uint64_t id, uint64_t skipped = 0, uint64_t edits = 0) {
    client::WatchedFrame out;
    out.frame_id = id;
    out.skipped_frames = skipped;
    out.edit_count = edits;
    for (uint32_t mesh = 0; mesh < 2; ++mesh) {
      v1::VertexSample& sample = out.positions.emplace_back();
      sample.set_mesh(mesh);
      sample.set_positions(std::string(36, static_cast<char>(id)));
    }
    return out;
  }

 private:
  fs::path folder_;
};

TEST_F(LiveRecorderTest, WhatWasWatchedIsReadBack) {
  LiveRecorder recorder(recording(), scene_of_two(), {both()});
  EXPECT_TRUE(recorder.add(frame(5)));
  EXPECT_TRUE(recorder.add(frame(9, 3)));
  recorder.finish();
  RecordingReader reader(recording());
  const RecordedMeshes meshes(reader.spec());
  ASSERT_EQ(meshes.inputs().size(), 2u);
  EXPECT_EQ(meshes.inputs()[1].triangles[0], (std::array<uint32_t, 3>{0, 2, 1}));
  EXPECT_TRUE(meshes.inputs()[1].is_static);
  const auto first = reader.next_frame(), second = reader.next_frame();
  EXPECT_EQ(first->frame_id(), 5u);
  EXPECT_EQ(first->updates_size(), 2);
  EXPECT_EQ(second->frame_id(), 9u);
  ASSERT_EQ(second->updates_size(), 1) << "what is static is sent once";
  EXPECT_EQ(second->updates(0).positions(), std::string(36, 9));
  EXPECT_FALSE(reader.next_frame());
  EXPECT_NE(recorder.summary().find("3 frames were missed in 1 gaps"), std::string::npos) << recorder.summary();
}

TEST_F(LiveRecorderTest, PositionsOfAMeshThatIsNotThereAreRefused) {
  LiveRecorder recorder(recording(), scene_of_two(), {both()});
  client::WatchedFrame wrong = frame(1);
  wrong.positions[1].set_mesh(2);
  EXPECT_THROW(recorder.add(wrong), std::runtime_error);
}

TEST_F(LiveRecorderTest, AnEditEndsTheRecording) {
  LiveRecorder recorder(recording(), scene_of_two(), {both()});
  EXPECT_TRUE(recorder.add(frame(1)));
  EXPECT_FALSE(recorder.add(frame(2, 0, 1)));
  recorder.finish();
  EXPECT_EQ(RecordingReader(recording()).count_frames(), 1);
  EXPECT_NE(recorder.summary().find("an edit changed the meshes"), std::string::npos);
}

TEST_F(LiveRecorderTest, MeshesMayBeInSeveralFiles) {
  const std::string one = put("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const SceneElements elements(scene_of_two().spec(), {one, one});
  EXPECT_EQ(elements.inputs()[1].triangles[0], (std::array<uint32_t, 3>{0, 1, 2}));
  EXPECT_THROW(SceneElements(scene_of_two().spec(), {one}), std::runtime_error);
  const std::string across =
      put("across.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 4\nf 3 5 6\n");
  EXPECT_THROW(SceneElements(scene_of_two().spec(), {across}), std::runtime_error);
}

TEST_F(LiveRecorderTest, WhatAWatchDoesNotShowWholeIsRefused) {
  v1::Scene scene = scene_of_two();
  scene.set_vertex_count((2 << 20) / 12);
  EXPECT_EQ(LiveRecorder::watch_options(scene).vertex_stride, 1u);
  EXPECT_EQ(LiveRecorder::watch_options(scene).meshes, (std::vector<uint32_t>{0, 1}));
  scene.set_vertex_count((2 << 20) / 12 + 1);
  EXPECT_THROW(LiveRecorder::watch_options(scene), std::runtime_error);
  scene = scene_of_two();
  scene.mutable_spec()->set_position_format(v1::POSITION_FORMAT_Q16);
  EXPECT_THROW(LiveRecorder::watch_options(scene), std::runtime_error);
}

}  // namespace
}  // namespace collided::cli
