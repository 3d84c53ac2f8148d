// New positions of some vertices only: the same contacts as with whole meshes, and refusals that change nothing.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 20;

// Some vertices, chosen at random for each frame, and their positions in it.
struct Moved {
  std::vector<uint32_t> indices;
  Points starts, ends;
};

Moved move_some(Points& points, std::mt19937& random) {
  Moved moved;
  std::uniform_real_distribution<double> up(-0.02, 0.02);
  for (uint32_t i = 0; i < points.size(); ++i) {
    if (random() % 10) continue;
    moved.indices.push_back(i);
    moved.starts.push_back(points[i]);
    points[i][2] += up(random);
    moved.ends.push_back(points[i]);
  }
  return moved;
}

pb::Frame sparse_frame(uint64_t id, const Moved& moved, bool with_starts) {
  auto frame = layers_frame(id, pack_points(moved.ends));
  auto* update = frame.mutable_updates(0);
  update->mutable_sparse()->set_indices(pack(moved.indices));
  if (with_starts) update->set_start_positions(pack_points(moved.starts));
  return frame;
}

class Sparse : public testing::Test {
 protected:
  void expect_same_as_whole(pb::DetectionMode mode, bool with_starts) {
    auto request = layers_request(kSide);
    request.mutable_spec()->set_mode(mode);
    Stream sparse(*stub_, make_scene(*stub_, request)), whole(*stub_, make_scene(*stub_, request));
    Points points = layer_points(kSide);
    std::mt19937 random(1);
    uint64_t contacts = 0;
    for (uint64_t id = 1; id <= 10; ++id) {
      const Moved moved = move_some(points, random);
      const auto full = layers_frame(id, pack_points(points));
      const Answer expected = whole.ask(full);
      const Answer answer = sparse.ask(id == 1 ? full : sparse_frame(id, moved, with_starts));
      ASSERT_TRUE(expected.done && answer.done) << (answer.error ? answer.error->message() : "ended");
      EXPECT_EQ(answer.contacts(), expected.contacts()) << "frame " << id;
      contacts += answer.done->contact_count();
    }
    EXPECT_GT(contacts, 100u);
  }

  // A good frame, one whose sparse update of the tip is changed, and a good one that continues from the first.
  void expect_refused(const std::function<void(pb::MeshUpdate&)>& change, const std::string& field) {
    Stream stream(*stub_, make_scene(*stub_, tip_request()));
    EXPECT_EQ(stream.ask(first_frame(0.5)).done->contact_count(), 0u);
    auto bad = corner(2, {0}, {{0, 0, -9}});
    change(*bad.mutable_updates(0));
    const Answer refused = stream.ask(bad);
    ASSERT_TRUE(refused.error) << field;
    EXPECT_EQ(refused.error->code(), grpc::INVALID_ARGUMENT) << refused.error->message();
    EXPECT_EQ(refused.error->field(), "frame.updates[0]." + field) << refused.error->message();
    expect_tip_contact(stream.ask(corner(2, {0}, {{0, 0, -0.5}})), 2);
  }

  static pb::Frame corner(uint64_t id, const std::vector<uint32_t>& indices, const Points& positions) {
    pb::Frame frame;
    frame.set_frame_id(id);
    auto* tip = frame.add_updates();
    tip->set_mesh(1);
    tip->mutable_sparse()->set_indices(pack(indices));
    tip->set_positions(pack_points(positions));
    return frame;
  }

  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(Sparse, DiscreteFramesEqualWholeOnes) { expect_same_as_whole(pb::DETECTION_MODE_DCD, false); }
TEST_F(Sparse, ContinuousFramesEqualWholeOnes) { expect_same_as_whole(pb::DETECTION_MODE_CCD, false); }
TEST_F(Sparse, StartPositionsEqualWholeOnes) { expect_same_as_whole(pb::DETECTION_MODE_CCD, true); }

TEST_F(Sparse, NoVertexAtAllLeavesAllWhereItIs) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  expect_tip_contact(stream.ask(first_frame(2)), 2);
  const Answer still = stream.ask(corner(2, {}, {}));
  ASSERT_TRUE(still.done) << (still.error ? still.error->message() : "ended");
  EXPECT_EQ(still.done->contact_count(), 0u);  // the corner stays below the floor
}

TEST_F(Sparse, IndicesThatDoNotRiseAreRefused) {
  const auto two = pack_points({{0, 0, -9}, {0, 0, -9}});
  for (const auto& indices : {std::vector<uint32_t>{1, 0}, {1, 1}})
    expect_refused(
        [&](auto& update) {
          update.mutable_sparse()->set_indices(pack(indices));
          update.set_positions(two);
        },
        "sparse.indices");
}

TEST_F(Sparse, IndicesOutsideTheMeshAreRefused) {
  for (const uint32_t index : {3u, 0xffffffffu})
    expect_refused([&](auto& u) { u.mutable_sparse()->set_indices(pack<uint32_t>({index})); }, "sparse.indices");
}

TEST_F(Sparse, BrokenLengthsAreRefused) {
  expect_refused([](auto& u) { u.mutable_sparse()->mutable_indices()->pop_back(); }, "sparse.indices");
  expect_refused([](auto& u) { u.mutable_sparse()->set_indices(pack<uint32_t>({0, 1})); }, "positions");
  expect_refused([](auto& u) { u.mutable_positions()->pop_back(); }, "positions");
  expect_refused([](auto& u) { u.set_start_positions(std::string(24, '\0')); }, "start_positions");
}

TEST_F(Sparse, MoreIndicesThanVerticesAreRefused) {
  expect_refused(
      [](auto& update) {
        update.mutable_sparse()->set_indices(std::string(4 << 16, '\1'));
        update.set_positions(std::string(12 << 16, '\0'));
      },
      "sparse.indices");
}

TEST_F(Sparse, SharedMemoryIsRefusedOverGrpc) {
  expect_refused([](auto& u) { u.mutable_sparse()->mutable_shared_indices(); }, "sparse.shared_indices");
  expect_refused([](auto& u) { u.mutable_shared_positions(); }, "shared_positions");
  expect_refused([](auto& u) { u.mutable_shared_start_positions(); }, "shared_start_positions");
}

TEST_F(Sparse, AMeshsFirstFrameIsWhole) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  auto sparse = first_frame(2);
  sparse.mutable_updates(0)->mutable_sparse()->set_indices(pack<uint32_t>({0, 1, 2}));
  const Answer refused = stream.ask(sparse);
  ASSERT_TRUE(refused.error);
  EXPECT_EQ(refused.error->code(), grpc::INVALID_ARGUMENT) << refused.error->message();
  EXPECT_EQ(refused.error->field(), "frame.updates[0].sparse.indices");
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

}  // namespace
}  // namespace collided::test
