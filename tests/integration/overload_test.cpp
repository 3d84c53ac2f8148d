// More work than the daemon takes at once.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/integration/daemon_process.hpp"
#include "tests/integration/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 120;  // enough for a frame to take longer than a few frames to arrive

// Two square grids of side 1, one just above the other.
Points layers() {
  Points points;
  for (const double z : {0.0, 0.001})
    for (uint32_t y = 0; y < kSide; ++y)
      for (uint32_t x = 0; x < kSide; ++x) points.push_back({double(x) / kSide, double(y) / kSide, z});
  return points;
}

std::vector<uint32_t> layer_triangles() {
  std::vector<uint32_t> triangles;
  for (uint32_t row = 0; row < 2 * kSide; ++row)
    for (uint32_t x = 0; row % kSide + 1 < kSide && x + 1 < kSide; ++x) {
      const uint32_t i = row * kSide + x, up = i + kSide;
      triangles.insert(triangles.end(), {i, i + 1, up, up + 1, up, i + 1});
    }
  return triangles;
}

pb::CreateSceneRequest layers_request() {
  pb::CreateSceneRequest request;
  auto* spec = request.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_DCD);
  spec->set_thickness(0.005);
  auto* mesh = spec->add_meshes();
  mesh->set_name("layers");
  mesh->set_vertex_count(2 * kSide * kSide);
  mesh->set_triangles(pack(layer_triangles()));
  return request;
}

pb::Frame layers_frame(uint64_t id, const std::string& positions) {
  pb::Frame frame;
  frame.set_frame_id(id);
  frame.add_updates()->set_positions(positions);
  return frame;
}

// Sends frames without a pause and counts those that were refused because too many waited. receive() checks the order.
void count_refused(Stub& stub, const std::string& scene, uint64_t first, std::atomic<int>& refused) {
  constexpr uint64_t kFrames = 16;
  const std::string positions = pack_points(layers(), false);
  Stream stream(stub, scene, kFrames);
  std::thread sender([&] {
    for (uint64_t id = first; id < first + kFrames; ++id) stream.send(layers_frame(id, positions));
  });
  for (uint64_t id = first; id < first + kFrames; ++id) {
    const Answer answer = stream.receive(id);
    EXPECT_FALSE(answer.ended);
    if (answer.error && answer.error->code() == grpc::RESOURCE_EXHAUSTED) ++refused;
  }
  sender.join();
}

TEST(Overload, RefusalsKeepTheOrderOfTheFrames) {
  DaemonProcess daemon({"--threads", "1"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto scene = make_scene(*stub, layers_request());
  std::atomic<int> refused = 0;
  std::thread other([&] { count_refused(*stub, scene, 101, refused); });
  count_refused(*stub, scene, 1, refused);
  other.join();
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace collided::test
