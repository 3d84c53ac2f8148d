// A daemon remembers how much room scenes needed, for scenes of the same client with the same triangles.
#include <gtest/gtest.h>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kTriangles = 60;

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Sheets of one triangle, all of them nearer to each other than the thickness.
pb::CreateSceneRequest stack() {
  pb::CreateSceneRequest request;
  auto* spec = request.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_DCD);
  spec->set_thickness(1);
  auto* mesh = spec->add_meshes();
  mesh->set_name("stack");
  mesh->set_vertex_count(3 * kTriangles);
  mesh->set_triangle_count(kTriangles);
  std::vector<uint32_t> ids;
  for (uint32_t i = 0; i < 3 * kTriangles; ++i) ids.push_back(i);
  mesh->set_triangles(bytes_of(ids));
  return request;
}

pb::Frame frame_of_stack() {
  std::vector<float> positions;
  for (uint32_t i = 0; i < kTriangles; ++i) {
    const float z = 0.001f * static_cast<float>(i);
    positions.insert(positions.end(), {0, 0, z, 1, 0, z, 0, 1, z});
  }
  pb::Frame frame;
  frame.set_frame_id(1);
  frame.add_updates()->set_positions(bytes_of(positions));
  return frame;
}

pb::FrameDone first_frame_of(Stub& stub, const pb::CreateSceneRequest& request) {
  const auto id = make_scene(stub, request);
  pb::DetectFrameResponse answer;
  const auto status = detect(stub, id, frame_of_stack(), &answer);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return answer.done();
}

TEST(KnownLengths, SpareTheNextSceneWhatTheFirstHadToDoTwice) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto first = first_frame_of(*stub, stack()), second = first_frame_of(*stub, stack());
  ASSERT_GT(first.metrics().replays(), 0u);
  EXPECT_LT(second.metrics().replays(), first.metrics().replays());
  EXPECT_EQ(second.contact_count(), first.contact_count());
  auto other = stack();
  other.mutable_spec()->set_thickness(2);
  EXPECT_EQ(first_frame_of(*stub, other).metrics().replays(), first.metrics().replays());
}

TEST(KnownLengths, AnExpectationBeyondAllMemoryHarmsNothing) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto without = first_frame_of(*stub, stack());
  auto greedy = stack();
  greedy.mutable_spec()->set_expected_contacts(4294967295);
  EXPECT_EQ(first_frame_of(*stub, greedy).contact_count(), without.contact_count());
}

}  // namespace
}  // namespace collided::test
