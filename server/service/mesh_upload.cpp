// One UploadMesh call.
#include "server/service/mesh_upload.hpp"

#include "server/errors.hpp"
#include "server/service/status.hpp"

namespace collided::server {
namespace {

constexpr size_t kMostUploads = 1024, kMostOfClient = 256;  // that wait for their client at once

}  // namespace

MeshUpload::MeshUpload(const grpc::CallbackServerContext& context, const UploadParts& parts, grpc::ByteBuffer* response,
                       std::shared_ptr<void> held)
    : context_(context), host_(parts.host), parts_(parts), response_(response), held_(std::move(held)) {
  try {
    caller_ = identify(context_, parts_.calls.authenticator);
    read();
  } catch (...) {
    Finish(to_status(describe_current()));
  }
}

// A client that says nothing for too long is let go of, with its scene's lease.
void MeshUpload::read() {
  const WaitRule rule{"the next chunk of an upload", host_.limits().max_silent_seconds, kMostUploads, kMostOfClient};
  wait_ = parts_.waiting.wait(rule, caller_.client,
                              [this](const std::exception_ptr& why) { finish(to_status(describe(why))); });
  StartRead(&bytes_);
}

void MeshUpload::OnReadDone(bool ok) {
  if (!wait_->over()) return;  // the call has been ended
  try {
    if (!ok) return commit();
    parse();
    if (!scene_) begin();
    take();
    read();
  } catch (...) {
    finish(to_status(describe_current()));
  }
}

void MeshUpload::parse() {
  request_.Clear();
  parse_bounded(bytes_, caller_.client, parts_.calls, request_);
  bytes_.Clear();
}

void MeshUpload::begin() {
  auto scene = host_.scenes().find(caller_.client, request_.scene_id());
  mesh_ = request_.mesh();
  const auto& meshes = scene->plan().meshes;
  if (mesh_ >= meshes.size())
    throw InvalidInput("mesh", fmt::format("mesh is {}, but the scene has {} meshes", mesh_, meshes.size()));
  scene->begin_upload(mesh_);
  scene_ = std::move(scene);
}

// The mesh is free again before the client knows the outcome, and may try anew.
void MeshUpload::finish(const grpc::Status& status) {
  if (scene_) scene_->end_upload(mesh_);
  Finish(status);
}

void MeshUpload::take() {
  parse_triangles(request_.triangles(), scene_->plan().engine.meshes[mesh_].vertex_count, "triangles", triangles_);
  const uint64_t awaited = scene_->awaited(mesh_);
  if (triangles_.size() > awaited)
    throw InvalidInput("triangles",
                       fmt::format("triangles brings {} or more, but the mesh awaits {}", triangles_.size(), awaited));
}

// A call that was cancelled ends its reads just as one that is complete.
void MeshUpload::check_cancelled() const {
  if (context_.IsCancelled()) throw Cancelled();
}

// Its triangles are spent, so no other upload could make it ready.
void MeshUpload::delete_if_unusable() {
  if (!scene_->unusable()) return;
  try {
    host_.scenes().remove(scene_->facts().owner, scene_->id());
    log_event(spdlog::level::info, "scene deleted: its meshes make no scene",
              {{"scene", scene_->id()}, {"request", caller_.ids.request_id}, {"trace", caller_.ids.trace_id}});
  } catch (const NotFound&) {  // a client was faster
  }
}

void MeshUpload::commit() {
  check_cancelled();
  if (!scene_) throw InvalidInput("scene_id", "scene_id is missing: the upload had no chunk");
  scene_->worker().post([this] {
    try {
      check_cancelled();
      scene_->add_triangles(mesh_, triangles_);
      pb::UploadMeshResponse response;
      fill_scene(*scene_, response.mutable_scene());
      *response_ = to_bytes(response);
      log_event(spdlog::level::info, "mesh uploaded",
                {{"scene", scene_->id()},
                 {"mesh", mesh_},
                 {"triangles", triangles_.size()},
                 {"request", caller_.ids.request_id},
                 {"trace", caller_.ids.trace_id}});
      finish(grpc::Status::OK);
    } catch (...) {
      const Failure failure = describe_current();
      delete_if_unusable();
      finish(to_status(failure));
    }
  });
}

}  // namespace collided::server
