// The C++ client's sets.

#include "client/cpp/batch/scene_set.hpp"

#include "client/cpp/positions.hpp"
#include "tests/integration/batch/tip_set.hpp"

namespace collided::test {
namespace {

class SceneSets : public testing::Test {
 protected:
  client::SceneSet make(uint32_t count) {
    pb::SceneSpec spec = tip_request().spec();
    spec.clear_meshes();
    const client::MeshInput meshes[] = {{.name = "floor", .vertex_count = 3, .triangles = triangle_, .is_static = true},
                                        {.name = "tip", .vertex_count = 3, .triangles = triangle_}};
    return client::SceneSet::create(client_, spec, meshes, count);
  }
  static client::SetOutput step(client::SceneSet& set, const std::vector<double>& depths, bool first,
                                std::span<const uint32_t> worlds = {}) {
    const Falls of = falls(depths, first);
    return set.detect({.positions = std::as_bytes(std::span(of.end)),
                       .start_positions = std::as_bytes(std::span(of.start)),
                       .worlds = worlds});
  }

  const std::vector<std::array<uint32_t, 3>> triangle_ = {{0, 1, 2}};
  DaemonProcess daemon_;
  client::Client client_ = client::Client::connect(daemon_.address());
};

TEST_F(SceneSets, AnswerByWorld) {
  client::SceneSet set = make(4);
  EXPECT_EQ(set.worlds(), 4u);
  const client::SetOutput all = step(set, {2, 0.5, 2, 3}, true);
  EXPECT_EQ(all.vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 1, 2, 3}));
  EXPECT_EQ(all.edge_edge.begin, (std::vector<uint64_t>{0, 0, 0, 0, 0}));
  EXPECT_EQ(all.vertex_triangle.elements[2], (std::array<uint32_t, 2>{3, 0}));
  const uint32_t worlds[] = {1, 2};
  EXPECT_EQ(step(set, {2, 0.5}, false, worlds).vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 1}));
  set.close();
  EXPECT_THROW(step(set, {2, 2, 2, 2}, false), client::Error);
}

TEST_F(SceneSets, RefusalsAreToldAndLeaveTheSetOpen) {
  client::SceneSet set = make(2);
  const client::SetOutput bad = step(set, {2, std::numeric_limits<double>::infinity()}, true);
  ASSERT_EQ(bad.refused.size(), 1u);
  EXPECT_EQ(bad.refused[0].world(), 1u);
  EXPECT_EQ(bad.vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 1}));
  EXPECT_THROW(step(set, {2}, false), client::Error) << "two worlds need more bytes";
  EXPECT_EQ(step(set, {2, 2}, true).refused.size(), 1u) << "the first world's floor came already";
}

TEST_F(SceneSets, OneCallStepsSeveral) {
  client::SceneSet one = make(2), other = make(3);
  const Falls a = falls({2, 2}, true), b = falls({0.5, 2, 0.5}, true);
  const auto update = [](const Falls& of) {
    return client::SetUpdate{.positions = std::as_bytes(std::span(of.end)),
                             .start_positions = std::as_bytes(std::span(of.start))};
  };
  const client::SetStep steps[] = {{&one, update(a)}, {&other, update(b)}};
  const auto outputs = client::detect_batch(steps);
  ASSERT_EQ(outputs.size(), 2u);
  EXPECT_EQ(outputs[0].vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 2}));
  EXPECT_EQ(outputs[1].vertex_triangle.begin, (std::vector<uint64_t>{0, 0, 1, 1}));
}

}  // namespace
}  // namespace collided::test
