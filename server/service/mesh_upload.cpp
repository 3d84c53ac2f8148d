// One UploadMesh call.
#include "server/service/mesh_upload.hpp"

#include <fmt/format.h>

#include <utility>

#include "server/convert/facts.hpp"
#include "server/convert/meshes.hpp"
#include "server/errors.hpp"
#include "server/refusals/status.hpp"

namespace collided::server {
namespace {

constexpr size_t kMaxUnstarted = 1024, kMaxUnstartedOfClient = 256;  // uploads that have had no chunk

}  // namespace

MeshUpload::MeshUpload(const grpc::CallbackServerContext& context, SceneHost& host, const CallParts& parts,
                       grpc::ByteBuffer* response, std::shared_ptr<void> held)
    : context_(context),
      host_(host),
      parts_(parts),
      response_(response),
      held_(std::move(held)),
      upload_(std::make_shared<Upload>([this](const std::exception_ptr& why) { Finish(to_status(describe(why))); },
                                       Upload::Clock::now())) {
  try {
    caller_ = identify(context, parts_.authenticator);
    await_first();
    host_.uploads().add(upload_);
    read();
  } catch (...) {
    finish(to_status(describe_current()));
  }
}

// An upload counts as one of its client's streams only once it has begun, so those before that are limited here. The
// call lives until it is finished, so whoever comes too late to finish it must not touch it.
void MeshUpload::await_first() {
  const WaitRule rule{"the first chunk of the upload", host_.limits().max_silent_seconds, kMaxUnstarted,
                      kMaxUnstartedOfClient, context_.peer()};
  first_chunk_ = parts_.waiting.wait(rule, caller_.client, [this, upload = upload_](const std::exception_ptr& why) {
    if (upload->end()) Finish(to_status(describe(why)));
  });
}

void MeshUpload::read() {
  upload_->wait([this] { StartRead(&bytes_); });
}

void MeshUpload::OnReadDone(bool ok) try {
  if (first_chunk_ && !first_chunk_->finish()) return;  // the call has been ended
  first_chunk_.reset();
  if (!upload_->receive(Upload::Clock::now())) return;
  if (!ok) return commit();
  check_message_size(bytes_.Length(), parts_.max_message_bytes);
  share_ = parts_.budget.take(caller_.client, bytes_.Length());
  parts_.work.post(caller_.client->turn_path(), [this] { take_chunk(); });
} catch (...) {
  finish(to_status(describe_current()));
}

// Nobody else ends the call between receive() and read().
void MeshUpload::take_chunk() try {
  parse();
  if (!upload_->scene()) begin();
  take();
  request_ = {};  // frees its memory: the next chunk may take long to arrive
  share_.reset();
  read();
} catch (...) {
  finish(to_status(describe_current()));
}

void MeshUpload::parse() {
  share_.reset();
  share_ = parse_bounded(bytes_, caller_.client, parts_, request_);
  bytes_.Clear();
}

void MeshUpload::begin() {
  auto ticket = host_.usage().begin_stream(caller_.client);
  upload_->begin(host_.scenes().find(caller_.client, request_.scene_id()), request_.mesh(), std::move(ticket));
}

void MeshUpload::finish(const grpc::Status& status) {
  if (upload_->end()) Finish(status);
}

void MeshUpload::take() try {
  const uint32_t vertices = upload_->scene()->plan()->engine.meshes[upload_->mesh()].vertex_count;
  ReceivedTriangles& triangles = upload_->triangles();
  const std::string& bytes = request_.triangles();
  upload_->reserve(bytes.size() / sizeof(TriangleCorners));
  for_each_triangle(bytes, vertices, {"triangles", triangles.size()},
                    [&](const TriangleCorners& triangle) { triangles.push(triangle); });
} catch (const InvalidInput& e) {
  throw InvalidInput(e.field(), fmt::format("{}, in {}", e.what(), upload_->mesh_name()));
}

// The reads of a cancelled call end like those of a complete one.
void MeshUpload::check_cancelled() const {
  if (context_.IsCancelled()) throw Cancelled();
}

// The triangles are consumed, so no other upload could complete the scene.
void MeshUpload::delete_if_unusable() {
  const Scene& scene = *upload_->scene();
  if (!scene.unusable()) return;
  try {
    const auto removed = host_.scenes().remove(scene.identity().owner, scene.id());
    removed->release();
    log_event(spdlog::level::info, "scene deleted: its meshes form no valid scene",
              {{"scene", scene.id()}, {"request", caller_.ids.request_id}, {"trace", caller_.ids.trace_id}});
  } catch (const std::exception&) {  // a client has already deleted it; or memory is short, and its lease will end it
  }
}

void MeshUpload::commit() {
  check_cancelled();
  if (!upload_->scene()) throw InvalidInput("scene_id", "scene_id is missing: the upload had no chunk");
  upload_->scene()->worker().post([this] {
    try {
      add_to_scene();
      finish(grpc::Status::OK);
    } catch (...) {
      const Failure failure = describe_current();
      delete_if_unusable();
      finish(to_status(failure));
    }
  });
}

void MeshUpload::add_to_scene() {
  check_cancelled();
  Scene& scene = *upload_->scene();
  const uint64_t count = upload_->triangles().size();
  scene.add_triangles(upload_->mesh(), upload_->triangles());
  pb::UploadMeshResponse response;
  fill_scene(scene, response.mutable_scene());
  *response_ = to_bytes(response);
  log_event(spdlog::level::info, "mesh uploaded",
            {{"scene", scene.id()},
             {"mesh", upload_->mesh()},
             {"triangles", count},
             {"request", caller_.ids.request_id},
             {"trace", caller_.ids.trace_id}});
}

}  // namespace collided::server
