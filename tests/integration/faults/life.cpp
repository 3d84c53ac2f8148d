// A scene and its stream in stages.
#include "tests/integration/faults/life.hpp"

#include <absl/status/status.h>

#include "tests/integration/support/upload.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 12, kVertices = kSide * kSide;

std::vector<uint32_t> grid() {
  auto triangles = layer_triangles(kSide);
  triangles.resize(triangles.size() / 2);
  return triangles;
}

// Two grids in CCD; the first awaits its triangles.
pb::CreateSceneRequest request() {
  pb::CreateSceneRequest request;
  request.set_lease_seconds(600);
  auto* spec = request.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_CCD);
  spec->set_accuracy(pb::ACCURACY_CERTIFIED);
  for (const char* name : {"low", "high"}) {
    auto* mesh = spec->add_meshes();
    mesh->set_name(name);
    mesh->set_vertex_count(kVertices);
    if (spec->meshes_size() == 1)
      mesh->set_triangle_count(static_cast<uint32_t>(grid().size() / 3));
    else
      mesh->set_triangles(pack(grid()));
  }
  return request;
}

std::string points_at(double z) {
  Points points = layer_points(kSide);
  points.resize(kVertices);
  for (auto& point : points) point[2] = z;
  return pack_points(points);
}

// Above the low grid in one frame, below it in the next, so that each frame's contacts tell where the last one ended.
double height(uint64_t id) { return (id % 2 ? -0.01 : 0.01) * static_cast<double>(id); }

Outcome from(const grpc::Status& status) {
  if (status.ok()) return {"ok", ""};
  return {absl::StatusCodeToString(static_cast<absl::StatusCode>(status.error_code())), status.error_message()};
}

Outcome from(int code, const std::string& message) { return from(grpc::Status(grpc::StatusCode(code), message)); }

int connections = 1000;  // each life has its own

}  // namespace

const std::vector<Life::Stage>& Life::stages() {
  static const std::vector<Stage> all{
      {"connect", &Life::connect},    {"create", &Life::create},     {"upload", &Life::upload},
      {"open", &Life::open},          {"first frame", &Life::frame}, {"later frame", &Life::frame},
      {"edit", &Life::edit},          {"after edit", &Life::frame},  {"close", &Life::close},
      {"DetectFrame", &Life::detect}, {"open again", &Life::open},   {"frame of second stream", &Life::frame},
      {"delete", &Life::remove}};
  return all;
}

Outcome Life::connect() {
  stub_ = pb::CollisionService::NewStub(channel_to(daemon_.process().address(), ++connections));
  grpc::ClientContext context;
  set_deadline(context);
  pb::GetServerInfoResponse info;
  return from(stub_->GetServerInfo(&context, {}, &info));
}

Outcome Life::create() {
  const auto status = create_scene(*stub_, request(), &scene_);
  return from(status);
}

// A refused upload may have ended the scene, of which it says so.
Outcome Life::upload() {
  if (get_scene(*stub_, scene_.scene_id()).error_code() == grpc::NOT_FOUND) {
    const Outcome created = create();
    if (!created.ok()) return created;
  }
  Upload call(*stub_, scene_.scene_id(), grid());
  return from(call.finish());
}

Outcome Life::open() {
  if (transport_ == Transport::kGrpc) {
    remote_.emplace(*stub_, scene_.scene_id(), 4, scene_.resume_token());
    if (!remote_->opened()) return end_of_stream();
    scene_.set_last_frame_id(remote_->opened()->scene().last_frame_id());
  } else {
    LocalSizes sizes;
    sizes.window = 4;
    sizes.resume_token = scene_.resume_token();
    local_.emplace(daemon_.path(), scene_.scene_id(), sizes);
    if (!local_->opened()) return end_of_stream();
    scene_.set_last_frame_id(local_->opened()->scene().last_frame_id());
  }
  return {"ok", ""};
}

Outcome Life::end_of_stream() {
  Outcome end;
  if (remote_) {
    end = from(remote_->wait_end());
    remote_.reset();
  } else {
    const auto closed = local_->closed() ? *local_->closed() : local_->raw().closed();
    end = closed.code() < 0 ? Outcome{"HUNG UP", closed.message()} : from(closed.code(), closed.message());
    local_.reset();
  }
  return end.ok() ? Outcome{"ENDED", "the stream ended as if its client had ended it"} : end;
}

pb::Frame Life::next_frame() const {
  const uint64_t id = done_ + 1;
  pb::Frame frame;
  frame.set_frame_id(id);
  auto* high = frame.add_updates();
  high->set_mesh(1);
  high->set_positions(points_at(height(id)));
  if (id > 1) return frame;
  high->set_start_positions(points_at(height(0) + 0.02));
  auto* low = frame.add_updates();
  low->set_mesh(0);
  low->set_positions(points_at(0));
  return frame;
}

Outcome Life::answered(const std::vector<pb::ContactChunk>& chunks, uint64_t id) {
  Answer answer;
  answer.chunks = chunks;
  std::string bytes;
  for (const auto& chunk : chunks)
    bytes += std::to_string(chunk.kind()) + chunk.elements() + chunk.stencils() + chunk.toi() + chunk.flags();
  done_ = id;
  const auto known = contacts_.emplace(id, bytes).first;
  EXPECT_GT(bytes.size(), 1000u) << "frame " << id << " tests little";
  return known->second == bytes ? Outcome{"ok", ""} : Outcome{"WRONG", "contacts are not those of an undisturbed run"};
}

Outcome Life::judge(uint64_t id, const Answer& answer) {
  if (answer.done) return answered(answer.chunks, id);
  if (answer.error) return from(answer.error->code(), answer.error->message());
  return answer.skipped ? Outcome{"SKIPPED", ""} : end_of_stream();
}

Outcome Life::ask(const pb::Frame& frame) {
  if (!remote_ && !local_) {
    const Outcome opened = open();
    if (!opened.ok()) return opened;
    if (scene_.last_frame_id() >= frame.frame_id()) {  // applied, and the stream's end has said that its answer is lost
      done_ = scene_.last_frame_id();
      return {"ok", ""};
    }
  }
  return judge(frame.frame_id(), remote_ ? remote_->ask(frame) : local_->ask_shared(frame));
}

Outcome Life::frame() { return ask(next_frame()); }

void Life::check_frame() {
  const Outcome outcome = frame();
  EXPECT_TRUE(outcome.ok()) << "the next frame: " << outcome.code << ": " << outcome.message;
}

// A third mesh comes.
Outcome Life::edit() {
  pb::Frame frame = next_frame();
  auto* edit = frame.mutable_edit()->add_meshes();
  edit->set_mesh(2);
  edit->mutable_spec()->set_name("third");
  edit->mutable_spec()->set_vertex_count(kVertices);
  edit->mutable_spec()->set_triangles(pack(grid()));
  auto* third = frame.add_updates();
  third->set_mesh(2);
  third->set_positions(points_at(0.001));
  third->set_start_positions(points_at(0.3));
  return ask(frame);
}

// Without a stream.
Outcome Life::detect() {
  const auto frame = next_frame();
  pb::DetectFrameResponse response;
  const auto status = test::detect(*stub_, scene_.scene_id(), frame, &response);
  if (status.error_message().find("was applied, but") != std::string::npos) done_ = frame.frame_id();
  if (!status.ok()) return from(status);
  return answered({response.contacts().begin(), response.contacts().end()}, frame.frame_id());
}

Outcome Life::close() {
  if (remote_) {
    const Outcome end = from(remote_->finish());
    remote_.reset();
    return end;
  }
  if (!local_) return {"ok", ""};  // it ended before
  local_->raw().half_close();
  const Outcome end = end_of_stream();
  return end.code == "ENDED" ? Outcome{"ok", ""} : end;
}

Outcome Life::remove() {
  Outcome outcome = from(delete_scene(*stub_, scene_.scene_id()));
  if (outcome.message.ends_with("which was deleted")) outcome = {"ok", ""};  // only the answer had failed
  remote_.reset();
  local_.reset();
  return outcome;
}

}  // namespace collided::test
