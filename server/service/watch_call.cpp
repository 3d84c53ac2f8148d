// One WatchScene call.
#include "server/service/watch_call.hpp"

#include <utility>

#include "server/convert/facts.hpp"
#include "server/errors.hpp"
#include "server/ops/log.hpp"
#include "server/ops/log_rate.hpp"

namespace collided::server {
namespace {

constexpr auto kLinger = std::chrono::seconds(10);  // for the last message if the client does not take it

// Each field of bytes is an array.
void truncate(pb::ContactChunk& chunk, uint32_t max) {
  const uint32_t count = chunk.count();
  if (count <= max) return;
  const google::protobuf::Descriptor& fields = *pb::ContactChunk::descriptor();
  for (int i = 0; i < fields.field_count(); ++i) {
    const google::protobuf::FieldDescriptor* field = fields.field(i);
    if (field->type() != google::protobuf::FieldDescriptor::TYPE_BYTES) continue;
    std::string array = chunk.GetReflection()->GetString(chunk, field);
    array.resize(array.size() / count * max);
    chunk.GetReflection()->SetString(&chunk, field, std::move(array));
  }
  chunk.set_count(max);
}

// The frame has as many contacts as the most demanding watcher wants.
void fill_done(const pb::FrameDone& frame, uint32_t max_contacts, pb::WatchSceneResponse& out) {
  pb::FrameDone& done = *out.mutable_done();
  done = frame;
  if (max_contacts == 0) done.clear_contacts();
  uint64_t shown = 0;
  for (pb::ContactChunk& chunk : *done.mutable_contacts()) {
    truncate(chunk, max_contacts);
    shown += chunk.count();
  }
  out.set_omitted_contacts(done.contact_count() - shown);
}

pb::WatchSceneResponse message_of(const WatchedUpdate& update, const WatchOptions& options) {
  pb::WatchSceneResponse message;
  message.set_frame_id(update.frame->frame_id);
  message.set_skipped_frames(update.skipped);
  message.set_edit_count(update.frame->edits);
  fill_done(update.frame->done, options.max_contacts, message);
  for (size_t i = 0; i < options.meshes.size(); ++i) {
    auto* sample = message.add_positions();
    sample->set_mesh(options.meshes[i]);
    sample->set_vertex_stride(update.vertex_stride);
    sample->set_positions(*update.positions[i]);
  }
  return message;
}

}  // namespace

grpc::ServerGenericBidiReactor* WatchCall::serve(grpc::CallbackServerContext& context, SceneHost& host,
                                                 const CallParts& parts, TimedJobs& jobs) {
  const std::shared_ptr<WatchCall> call(new WatchCall(context, host, parts, jobs));
  call->alive_ = call;
  call->begin();
  return call.get();
}

void WatchCall::answer() {
  host_.check_serving();
  join(host_.scenes().find(caller().client, request_.scene_id()));
  host_.check_serving();  // the stop may have been announced before the scene knew of the watcher
  request_ = {};
  share_.reset();
  log_event(spdlog::level::info, "watch opened",
            {{"scene", watcher_->scene().id()},
             {"client", caller().client->name},
             {"request", caller().ids.request_id},
             {"trace", caller().ids.trace_id}});
  send_opened();
}

// Room for the frame in the mailbox and for the one that is being sent is taken for as long as the watch lasts, so that
// no later frame is refused because of it.
void WatchCall::join(const SceneUse& scene) {
  const auto plan = scene->plan();
  auto watcher = std::make_shared<Watcher>(scene.scene(), parse_watch(request_, *plan), plan, weak_from_this());
  const WatchOptions& options = watcher->options();
  auto held = std::make_unique<MemoryHold>(scene->quota());
  held->resize(2 * max_watch_message_bytes(options, options.samples, *plan));
  {
    const std::lock_guard lock(mutex_);
    ticket_ = host_.usage().begin_stream(caller().client);
    held_ = std::move(held);
    watcher_ = std::move(watcher);
    is_open_ = true;
  }
  scene->record().begin_watch(watcher_);
  const std::lock_guard lock(mutex_);
  if (status_) scene->record().end_watch(*watcher_);  // the client was gone before the scene knew of it
}

void WatchCall::reserve(uint64_t message_bytes) {
  const std::lock_guard lock(mutex_);
  if (held_) held_->resize(2 * message_bytes);
}

void WatchCall::send_opened() {
  pb::WatchSceneResponse response;
  fill_scene(watcher_->scene(), response.mutable_opened()->mutable_scene());
  response.mutable_opened()->set_vertex_stride(watcher_->options().samples.stride);
  {
    const std::lock_guard lock(mutex_);
    if (held_) held_->resize(held_->bytes() + response.ByteSizeLong());
  }
  send(response);
}

void WatchCall::show(WatchedUpdate update) {
  const std::lock_guard lock(mutex_);
  if (status_) return;
  update_ = std::move(update);
  parts_.work.post(caller().client->turn_path(), [weak = weak_from_this()] {
    if (const auto call = weak.lock()) call->build_and_send();
  });
}

void WatchCall::build_and_send() {
  guard(*this, [&] {
    std::optional<WatchedUpdate> update;
    {
      const std::lock_guard lock(mutex_);
      update.swap(update_);
    }
    if (!update) return;
    next_ = Clock::now() + watcher_->options().period;
    send(message_of(*update, watcher_->options()));
  });
}

void WatchCall::send(const pb::WatchSceneResponse& response) {
  grpc::ByteBuffer bytes = to_bytes(response);
  const std::lock_guard lock(mutex_);
  if (status_) return;
  is_writing_ = true;
  bytes_.Swap(&bytes);
  StartWrite(&bytes_);
}

void WatchCall::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    is_writing_ = false;
    bytes_.Clear();
    if (status_) return finish_locked();
  }
  if (!ok) return OnCancel();
  watcher_->taken();
  await_next();
}

void WatchCall::await_next() {
  if (Clock::now() >= next_) return watcher_->ready();
  post(next_, &WatchCall::get_ready);
}

void WatchCall::get_ready() { watcher_->ready(); }

void WatchCall::cancel_write() {
  const std::lock_guard lock(mutex_);
  if (is_writing_) context_.TryCancel();
}

void WatchCall::post(Clock::time_point when, void (WatchCall::*step)()) {
  jobs_.post(when, [weak = weak_from_this(), step] {
    if (const auto call = weak.lock()) (*call.*step)();
  });
}

// Before the watch is open, the pending read or the first write fails, and that ends the call.
void WatchCall::OnCancel() {
  {
    const std::lock_guard lock(mutex_);
    if (!is_open_) return;
  }
  finish({grpc::StatusCode::CANCELLED, "the client is gone"});
}

void WatchCall::finish(const grpc::Status& status) {
  const auto alive = shared_from_this();  // once it is finished, gRPC may be done with it at any moment
  std::unique_lock lock(mutex_);
  if (status_) return;
  status_ = status;
  ticket_.reset();
  held_.reset();
  update_.reset();
  const auto watcher = watcher_;
  lock.unlock();
  if (watcher) watcher->close();
  log_end(status);
  lock.lock();
  finish_locked();
}

// A pending write has to complete before the status is sent.
void WatchCall::finish_locked() {
  if (is_writing_) return post(Clock::now() + kLinger, &WatchCall::cancel_write);
  if (!std::exchange(is_finishing_, true)) Finish(*status_);
}

void WatchCall::log_end(const grpc::Status& status) const {
  const std::string code = code_name(status.error_code());
  if (!admit_refusal("watch", code)) return;
  log_event(spdlog::level::info, "watch ends",
            {{"scene", watcher_ ? watcher_->scene().id() : std::string()},
             {"code", code},
             {"reason", status.error_message()},
             {"request", caller().ids.request_id},
             {"trace", caller().ids.trace_id}});
}

}  // namespace collided::server
