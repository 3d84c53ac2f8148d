// Client errors. After each refused frame the next good one has the right answer.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

class BadInput : public testing::Test {
 protected:
  using Change = std::function<void(pb::Frame&)>;

  // A scene with one good frame, then the frame with `change`, then a good frame.
  void expect_refused(const Change& change, grpc::StatusCode code, const std::string& field) {
    Stream stream(*stub_, make_scene(*stub_, tip_request()));
    expect_tip_contact(stream.ask(first_frame(2)), 2);
    auto bad = tip_frame(2, 2);
    change(bad);
    const Answer answer = stream.ask(bad);
    ASSERT_TRUE(answer.error) << field;
    EXPECT_EQ(answer.error->code(), code) << answer.error->message();
    EXPECT_EQ(answer.error->field(), field) << answer.error->message();
    EXPECT_NE(answer.error->message().find(field), std::string::npos) << answer.error->message();
    EXPECT_TRUE(answer.chunks.empty());
    auto good = tip_frame(2, 3);  // continues from the last good frame, whose tip ended at z = -1
    good.mutable_updates(0)->set_start_positions(pack_points(tip_points(1), false));
    expect_tip_contact(stream.ask(good), 3);
    EXPECT_TRUE(stream.finish().ok());
  }

  grpc::Status create(const std::function<void(pb::CreateSceneRequest&)>& change) {
    auto request = tip_request();
    change(request);
    return create_scene(*stub_, request);
  }

  DaemonProcess daemon_{{"--max-message-mb", "1", "--max-network-mb", "128"}};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(BadInput, NotANumber) {
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    expect_refused([&](auto& f) { f.mutable_updates(0)->set_positions(pack_points(tip_points(value), false)); },
                   grpc::INVALID_ARGUMENT, "frame.updates[0].positions");
  expect_refused([](auto& f) { f.mutable_updates(0)->set_start_positions(pack_points(tip_points(-1.0 / 0.0), false)); },
                 grpc::INVALID_ARGUMENT, "frame.updates[0].start_positions");
}

TEST_F(BadInput, WrongLength) {
  expect_refused([](auto& f) { f.mutable_updates(0)->mutable_positions()->pop_back(); }, grpc::INVALID_ARGUMENT,
                 "frame.updates[0].positions");
  expect_refused([](auto& f) { f.mutable_updates(0)->clear_positions(); }, grpc::INVALID_ARGUMENT,
                 "frame.updates[0].positions");
  expect_refused([](auto& f) { f.mutable_updates(0)->mutable_start_positions()->append(12, '\0'); },
                 grpc::INVALID_ARGUMENT, "frame.updates[0].start_positions");
}

TEST_F(BadInput, Meshes) {
  expect_refused([](auto& f) { f.mutable_updates(0)->set_mesh(2); }, grpc::INVALID_ARGUMENT, "frame.updates[0].mesh");
  expect_refused([](auto& f) { *f.add_updates() = f.updates(0); }, grpc::INVALID_ARGUMENT, "frame.updates[1].mesh");
  expect_refused([](auto& f) { f.mutable_updates(0)->set_mesh(0); }, grpc::INVALID_ARGUMENT,
                 "frame.updates[0].start_positions");
  const auto static_again = [](auto& f) {
    f.mutable_updates(0)->set_mesh(0);
    f.mutable_updates(0)->clear_start_positions();
  };
  expect_refused(static_again, grpc::INVALID_ARGUMENT, "frame.updates[0].mesh");
}

TEST_F(BadInput, FrameIds) {
  expect_refused([](auto& f) { f.set_frame_id(1); }, grpc::FAILED_PRECONDITION, "frame.frame_id");
  expect_refused([](auto& f) { f.set_frame_id(0); }, grpc::INVALID_ARGUMENT, "frame.frame_id");
}

TEST_F(BadInput, TransformsOfMeshesThatAreNotRigid) {
  const auto refused = [this](const std::string& matrix) {
    expect_refused([&](auto& f) { f.mutable_updates(0)->mutable_rigid()->set_matrix(matrix); }, grpc::INVALID_ARGUMENT,
                   "frame.updates[0].rigid.matrix");
  };
  refused("");
  refused(std::string(96, '\0'));
}

TEST_F(BadInput, Overrides) {
  for (const double delta : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    expect_refused([&](auto& f) { f.set_delta(delta); }, grpc::INVALID_ARGUMENT, "frame.delta");
  expect_refused([](auto& f) { f.set_accuracy(static_cast<pb::Accuracy>(9)); }, grpc::INVALID_ARGUMENT,
                 "frame.accuracy");
  expect_refused([](auto& f) { f.set_report(static_cast<pb::Report>(9)); }, grpc::INVALID_ARGUMENT, "frame.report");
  const auto fast_earliest = [](auto& f) {
    f.set_accuracy(pb::ACCURACY_FAST);
    f.set_report(pb::REPORT_EARLIEST_ONLY);
  };
  expect_refused(fast_earliest, grpc::INVALID_ARGUMENT, "frame.report");
}

TEST_F(BadInput, AnOverrideThatTheScenesReportForbids) {
  auto request = tip_request();
  request.mutable_spec()->set_report(pb::REPORT_EARLIEST_ONLY);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto fast = first_frame(2);
  fast.set_accuracy(pb::ACCURACY_FAST);
  const Answer answer = stream.ask(fast);
  ASSERT_TRUE(answer.error);
  EXPECT_EQ(answer.error->field(), "frame.accuracy");
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

TEST_F(BadInput, AnUnknownEngine) {
  const auto status =
      create([](auto& r) { r.mutable_spec()->set_broad_phase_engine(static_cast<pb::BroadPhaseEngine>(9)); });
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message(),
            "spec.broad_phase_engine is 9, but must be BROAD_PHASE_ENGINE_OCTREE, BROAD_PHASE_ENGINE_TOP_DOWN_OCTREE, "
            "BROAD_PHASE_ENGINE_BOTTOM_UP_OCTREE, BROAD_PHASE_ENGINE_UNIFORM_GRID, "
            "BROAD_PHASE_ENGINE_TWO_LEVEL_GRID, BROAD_PHASE_ENGINE_LBVH, BROAD_PHASE_ENGINE_VSS or "
            "BROAD_PHASE_ENGINE_ALL_PAIRS");
}

TEST_F(BadInput, FirstFrameMustNameEveryMesh) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  const Answer answer = stream.ask(tip_frame(1, 2));
  ASSERT_TRUE(answer.error);
  EXPECT_EQ(answer.error->field(), "frame.updates");
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

TEST_F(BadInput, DoublesForASceneOfFloats) {
  Stream stream(*stub_, make_scene(*stub_, tip_request(false)));
  const Answer answer = stream.ask(first_frame(2, true));
  ASSERT_TRUE(answer.error);
  EXPECT_EQ(answer.error->field(), "frame.updates[0].positions");
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

TEST_F(BadInput, AMessageThatIsTooLargeEndsItsStreamOnly) {
  const auto id = make_scene(*stub_, tip_request());
  {
    Stream stream(*stub_, id);
    auto frame = first_frame(2);
    frame.mutable_updates(0)->mutable_positions()->append(2 << 20, '\0');
    EXPECT_TRUE(stream.ask(frame).ended);
    EXPECT_EQ(stream.finish().error_code(), grpc::RESOURCE_EXHAUSTED);
  }
  Stream stream(*stub_, id);
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

// However large they are: no more is received than the quota of all calls.
TEST_F(BadInput, MessagesThatAreTooLargeDoNotFillTheDaemon) {
  constexpr double kQuota = 128, kSlack = 96;
  const Probe probe(daemon_);
  const auto id = make_scene(*stub_, tip_request());
  const double before = probe.peak_resident_bytes();
  for (const size_t bytes : {64 << 20, 400 << 20, 64 << 20}) {
    auto frame = first_frame(2);
    frame.mutable_updates(0)->mutable_positions()->append(bytes, '\0');
    EXPECT_EQ(detect(*stub_, id, frame).error_code(), grpc::RESOURCE_EXHAUSTED);
    Stream stream(*stub_, id);
    EXPECT_TRUE(stream.ask(frame).ended);
    EXPECT_EQ(stream.finish().error_code(), grpc::RESOURCE_EXHAUSTED);
    EXPECT_TRUE(probe.streams_become(0));
  }
  EXPECT_LT(probe.peak_resident_bytes() - before, memory_limit(kQuota + kSlack));
  Stream stream(*stub_, id);
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

TEST_F(BadInput, UnknownScenes) {
  Stream stream(*stub_, "0123");
  EXPECT_FALSE(stream.opened());
  const auto status = stream.finish();
  EXPECT_EQ(status.error_code(), grpc::NOT_FOUND);
  EXPECT_NE(status.error_message().find("0123"), std::string::npos);
  EXPECT_FALSE(status.error_details().empty());
  EXPECT_EQ(detect(*stub_, "", first_frame(2)).error_code(), grpc::NOT_FOUND);
}

TEST_F(BadInput, AStreamMustOpenFirst) {
  pb::StreamFramesRequest request;
  *request.mutable_frame() = first_frame(2);
  Stream stream(*stub_, request);
  EXPECT_EQ(stream.finish().error_code(), grpc::FAILED_PRECONDITION);
}

TEST_F(BadInput, Scenes) {
  const auto status = create([](auto& r) {
    r.mutable_spec()->mutable_meshes(1)->set_triangles(pack<uint32_t>({0, 1, 3}));
  });
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("spec.meshes[1].triangles[0]"), std::string::npos) << status.error_message();
  EXPECT_NE(status.error_details().find("google.rpc.BadRequest"), std::string::npos);
  const auto crossing = create([](auto& r) { r.mutable_spec()->add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE); });
  EXPECT_EQ(crossing.error_code(), grpc::INVALID_ARGUMENT);  // in a CCD scene
  EXPECT_NE(crossing.error_message().find("spec.kinds[0]"), std::string::npos) << crossing.error_message();
  EXPECT_EQ(create([](auto& r) { r.mutable_spec()->set_backend(pb::BACKEND_CPU); }).error_code(), grpc::OK);
}

}  // namespace
}  // namespace collided::test
