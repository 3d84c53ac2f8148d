// Every field of a frame takes effect on each path to the daemon: DetectFrame, StreamFrames and the local socket, with
// plain messages and through the C++ library. A new field of the protocol fails here until it has a probe.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <optional>
#include <set>

#include "client/cpp/client.hpp"
#include "server/daemon.hpp"
#include "tests/server/transport/local/serving.hpp"

namespace collided::server {
namespace {

using google::protobuf::Descriptor;

/// A frame's outcome, as the client sees it.
struct Told {
  pb::FrameDone done;
  std::string refusal;         ///< the message; empty if the frame was applied
  uint64_t last_frame_id = 0;  ///< of the scene afterwards
};

/// Sets a field in a frame that is answered with one contact at 1/2, and checks its effect in the answer.
struct Probe {
  std::function<void(pb::Frame&)> set;
  std::function<bool(const Told&)> has_effect;
};

pb::MeshUpdate& tip_of(pb::Frame& frame) { return *frame.mutable_updates(0); }

std::string tip_at(double z) { return test::pack_points(test::tip_points(z), false); }

std::function<bool(const Told&)> hits_at(double toi) {
  return [toi](const Told& told) {
    return told.refusal.empty() && told.done.earliest_toi() <= toi && told.done.earliest_toi() > toi - 1e-3;
  };
}

std::function<bool(const Told&)> is_refused(const std::string& message) {
  return [message](const Told& told) { return told.refusal.starts_with(message); };
}

// No path has that much shared memory.
pb::SharedRange far_range() {
  pb::SharedRange range;
  range.set_offset(uint64_t{1} << 40);
  range.set_size(36);
  return range;
}

void move_one_corner(pb::Frame& frame) {
  tip_of(frame).mutable_sparse()->set_indices(test::pack<uint32_t>({0}));
  tip_of(frame).set_start_positions(test::pack_points({test::tip_points(1)[0]}, false));
  tip_of(frame).set_positions(test::pack_points({test::tip_points(-3)[0]}, false));
}

void exclude_all(pb::Frame& frame) { frame.mutable_edit()->add_exclude_meshes()->set_second(1); }

bool has_no_contact(const Told& told) { return told.refusal.empty() && told.done.contact_count() == 0; }

const std::map<std::string, Probe> kProbes = {
    {"Frame.frame_id",
     {[](pb::Frame& f) { f.set_frame_id(9); }, [](const Told& told) { return told.last_frame_id == 9; }}},
    {"Frame.accuracy",
     {[](pb::Frame& f) { f.set_accuracy(pb::ACCURACY_CANDIDATES); },
      [](const Told& told) { return told.done.contact_count() > 1; }}},
    {"Frame.updates",
     {[](pb::Frame& f) { f.clear_updates(); },
      [](const Told& told) { return told.refusal.empty() && told.done.contact_count() == 0; }}},
    {"Frame.worlds",
     {[](pb::Frame& f) { f.add_worlds(0); }, is_refused("frame.worlds is given, but the scene is no set")}},
    {"Frame.meshes",
     {[](pb::Frame& f) { f.add_meshes(0); }, is_refused("frame.meshes is given, but the scene is no set")}},
    {"Frame.delta",
     {[](pb::Frame& f) { f.set_delta(1e-12); },
      [](const Told& told) { return told.done.metrics().warnings_size() == 1; }}},
    {"Frame.report",
     {[](pb::Frame& f) { f.set_report(pb::REPORT_ANY_HIT); },
      [](const Told& told) { return told.done.any_contact() && told.done.contact_count() == 0; }}},
    {"Frame.mode",
     {[](pb::Frame& f) { f.set_mode(pb::DETECTION_MODE_DCD); },
      is_refused("frame.mode is DCD, but the scene detects CCD alone")}},
    {"Frame.ignore_separating",
     {[](pb::Frame& f) {
        f.set_accuracy(pb::ACCURACY_FAST);
        f.set_ignore_separating(true);
      },
      is_refused("frame.ignore_separating is on")}},
    {"Frame.advance",
     {[](pb::Frame& f) { f.set_advance(true); },
      [](const Told& told) { return told.done.advanced() > 0.49 && told.done.advanced() < 0.5; }}},
    {"Frame.advance_mode",
     {[](pb::Frame& f) { f.set_advance_mode(pb::ADVANCE_MODE_PER_MESH); },
      is_refused("frame.advance_mode is ADVANCE_MODE_PER_MESH, but frame.advance is false")}},
    {"Frame.limits", {[](pb::Frame& f) { f.set_limits(true); }, is_refused("frame.limits is on, but advance is off")}},
    {"Frame.trial",
     {[](pb::Frame& f) { f.set_trial(true); }, [](const Told& told) { return told.last_frame_id == 1; }}},
    {"Frame.from_last_fraction",
     {[](pb::Frame& f) { f.set_from_last_fraction(1.5); }, is_refused("frame.from_last_fraction is 1.5")}},
    {"Frame.edit", {exclude_all, has_no_contact}},
    {"SceneEdit.exclude_meshes", {exclude_all, has_no_contact}},
    {"SceneEdit.include_meshes",
     {[](pb::Frame& f) { f.mutable_edit()->add_include_meshes(); }, is_refused("frame.edit.include_meshes[0] is ")}},
    {"SceneEdit.meshes",
     {[](pb::Frame& f) {
        f.clear_updates();
        f.mutable_edit()->add_meshes()->set_mesh(1);  // without a spec: it is removed
      },
      has_no_contact}},
    {"MeshEdit.mesh",
     {[](pb::Frame& f) { f.mutable_edit()->add_meshes()->set_mesh(7); }, is_refused("frame.edit.meshes[0].mesh is 7")}},
    {"MeshEdit.spec",
     {[](pb::Frame& f) {
        pb::MeshEdit& tip = *f.mutable_edit()->add_meshes();
        tip.set_mesh(1);
        tip.mutable_spec()->set_vertex_count(3);
        tip.mutable_spec()->set_groups(2);
        tip.mutable_spec()->set_collide_mask(2);
      },
      has_no_contact}},
    {"MeshUpdate.mesh", {[](pb::Frame& f) { tip_of(f).set_mesh(7); }, is_refused("frame.updates[0].mesh is 7")}},
    {"MeshUpdate.sparse", {move_one_corner, hits_at(0.25)}},
    {"MeshUpdate.rigid",
     {[](pb::Frame& f) { tip_of(f).mutable_rigid(); }, is_refused("frame.updates[0].rigid.matrix is empty")}},
    {"RigidTransform.matrix",
     {[](pb::Frame& f) { tip_of(f).mutable_rigid()->set_matrix("x"); },
      is_refused("frame.updates[0].rigid.matrix is given; mesh 1 is not rigid")}},
    {"RigidTransform.start_matrix",
     {[](pb::Frame& f) {
        tip_of(f).mutable_rigid()->set_start_matrix("x");
        tip_of(f).mutable_rigid()->set_matrix("x");
      },
      is_refused("frame.updates[0].rigid.")}},
    {"MeshUpdate.start_positions", {[](pb::Frame& f) { tip_of(f).set_start_positions(tip_at(3)); }, hits_at(0.75)}},
    {"MeshUpdate.positions", {[](pb::Frame& f) { tip_of(f).set_positions(tip_at(-3)); }, hits_at(0.25)}},
    {"MeshUpdate.shared_positions",
     {[](pb::Frame& f) {
        tip_of(f).clear_positions();
        *tip_of(f).mutable_shared_positions() = far_range();
      },
      is_refused("frame.updates[0].shared_positions is ")}},
    {"MeshUpdate.shared_start_positions",
     {[](pb::Frame& f) {
        tip_of(f).clear_start_positions();
        *tip_of(f).mutable_shared_start_positions() = far_range();
      },
      is_refused("frame.updates[0].shared_start_positions is ")}},
    {"SparseIndices.indices", {move_one_corner, hits_at(0.25)}},
    {"SparseIndices.shared_indices",
     {[](pb::Frame& f) {
        move_one_corner(f);
        *tip_of(f).mutable_sparse()->mutable_shared_indices() = far_range();
        tip_of(f).mutable_sparse()->clear_indices();
      },
      is_refused("frame.updates[0].sparse.shared_indices is ")}},
};

// Sent as parts of fields that have a probe.
bool is_part(const std::string& field) {
  return field.starts_with("SharedRange.") || field.starts_with("MeshSpec.") || field.starts_with("MeshPair.");
}

// All fields of a message and of its nested messages.
void add_fields(const Descriptor& type, std::set<std::string>& fields) {
  for (int i = 0; i < type.field_count(); ++i) {
    const auto& field = *type.field(i);
    const bool is_new = fields.insert(type.name() + "." + field.name()).second;
    if (is_new && field.message_type()) add_fields(*field.message_type(), fields);
  }
}

Told told_of(const test::Answer& answer) {
  if (answer.done) return {*answer.done, "", 0};
  return {{}, answer.error ? answer.error->message() : "the stream ended", 0};
}

class FrameOptions : public testing::Test {
 protected:
  using Way = std::function<Told(const std::string& scene, const std::vector<pb::Frame>& frames)>;

  FrameOptions() {
    config_.addresses = {"unix:" + folder_.file("socket")};
    config_.local_socket = folder_.file("local");
    daemon_.emplace(config_, lifecycle_);
    stub_ = pb::CollisionService::NewStub(test::channel_to(config_.addresses[0]));
    client_.emplace(client::Client::connect(config_.addresses[0]));
  }

  Told by_detect_frame(const std::string& scene, const std::vector<pb::Frame>& frames) {
    Told told;
    for (const auto& frame : frames) {
      pb::DetectFrameRequest request;
      request.set_scene_id(scene);
      *request.mutable_frame() = frame;
      pb::DetectFrameResponse response;
      grpc::ClientContext context;
      test::set_deadline(context);
      const auto status = stub_->DetectFrame(&context, request, &response);
      told = {response.done(), status.error_message(), 0};
    }
    return told;
  }
  template <class Stream>
  Told by_stream(Stream&& stream, const std::vector<pb::Frame>& frames) {
    Told told;
    for (const auto& frame : frames) told = told_of(stream.ask(frame));
    return told;
  }
  Told by_library(const std::string& scene, const std::vector<pb::Frame>& frames, client::Local local) {
    auto stream = client_->stream(client_->get_scene(scene), {.local = {.use = local}});
    EXPECT_EQ(stream.is_local(), local == client::Local::kOn);
    Told told;
    for (const auto& frame : frames) {
      stream.send(frame);
      const auto output = stream.receive();
      told = {output.done, output.error ? output.error->message() : "", 0};
    }
    stream.finish();
    return told;
  }

  // After a first frame whose tip stays above the floor.
  Told ask(const Way& way, const pb::Frame& frame) {
    const std::string scene = test::make_scene(*stub_, test::tip_request());
    Told told = way(scene, {test::first_frame(0.5), frame});
    told.last_frame_id = client_->get_scene(scene).last_frame_id();
    client_->delete_scene(scene);
    return told;
  }

  Folder folder_;
  Config config_ = Serving::cpu_config();
  Lifecycle lifecycle_;
  std::optional<Daemon> daemon_;
  std::unique_ptr<test::Stub> stub_;
  std::optional<client::Client> client_;

  const std::map<std::string, Way> ways_ = {
      {"DetectFrame", [this](const auto& scene, const auto& frames) { return by_detect_frame(scene, frames); }},
      {"StreamFrames",
       [this](const auto& scene, const auto& frames) { return by_stream(test::Stream(*stub_, scene), frames); }},
      {"local socket",
       [this](const auto& scene, const auto& frames) {
         return by_stream(LocalStream(folder_.file("local"), scene), frames);
       }},
      {"StreamFrames by the library",
       [this](const auto& scene, const auto& frames) { return by_library(scene, frames, client::Local::kOff); }},
      {"local socket by the library",
       [this](const auto& scene, const auto& frames) { return by_library(scene, frames, client::Local::kOn); }}};
};

TEST_F(FrameOptions, EveryFieldHasItsEffectOnEveryWay) {
  for (const auto& [way, ask_by] : ways_) {
    const Told plain = ask(ask_by, test::tip_frame(2, 2));
    EXPECT_TRUE(hits_at(0.5)(plain)) << way << ": " << plain.refusal;
    for (const auto& [field, probe] : kProbes) {
      EXPECT_FALSE(probe.has_effect(plain)) << field << " has its effect without being set, by " << way;
      pb::Frame frame = test::tip_frame(2, 2);
      probe.set(frame);
      const Told told = ask(ask_by, frame);
      EXPECT_TRUE(probe.has_effect(told))
          << field << " was lost on its way by " << way << ": " << told.refusal << told.done.ShortDebugString();
    }
  }
}

TEST(FrameOptionsProbes, ThereIsOneForEachField) {
  std::set<std::string> fields;
  add_fields(*pb::Frame::descriptor(), fields);
  for (const auto& field : fields)
    EXPECT_TRUE(kProbes.contains(field) || is_part(field))
        << field << " is new: add a probe that shows it to arrive on every way to the daemon";
  for (const auto& [field, probe] : kProbes) EXPECT_TRUE(fields.contains(field)) << field << " is no longer a field";
}

}  // namespace
}  // namespace collided::server
