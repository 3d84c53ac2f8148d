// One StreamFrames call.
#include "server/service/service_stream.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr uint32_t kDefaultWindow = 2;
constexpr size_t kMaxQueuedBytes = size_t{64} << 20;  // of answers that the client has not taken yet

uint32_t grant_window(uint32_t wanted, uint32_t limit) {
  if (wanted > limit)
    throw LimitExceeded("open.window", fmt::format("open.window is {}, more than the limit of {}", wanted, limit));
  return wanted ? wanted : std::min(kDefaultWindow, limit);
}

void check_open(const pb::OpenStream& open) {
  if (!open.resume_token().empty()) throw Unimplemented("open.resume_token", "open.resume_token is not served");
  if (open.delivery() == pb::DELIVERY_POLICY_LATEST_WINS)
    throw Unimplemented("open.delivery", "open.delivery is DELIVERY_POLICY_LATEST_WINS, which is not served");
  if (open.delivery() > pb::DELIVERY_POLICY_LATEST_WINS || open.delivery() < 0)
    throw InvalidInput("open.delivery", fmt::format("open.delivery is {}, which is no delivery policy",
                                                    static_cast<int>(open.delivery())));
}

bool ends_frame(const pb::StreamFramesResponse& response) { return response.has_done() || response.has_error(); }

}  // namespace

void FrameStream::start() {
  self_ = shared_from_this();
  std::lock_guard lock(mutex_);
  read_locked();
}

void FrameStream::refuse(const grpc::Status& status) {
  self_ = shared_from_this();
  std::lock_guard lock(mutex_);
  finish_locked(status);
}

void FrameStream::announce_stop(double seconds) {
  std::lock_guard lock(mutex_);
  // The first answer of a stream is `opened`, and this one will not open any more.
  if (!scene_) return finish_locked(to_status(describe(std::make_exception_ptr(Stopping()))));
  Response response;
  response.mutable_draining()->set_deadline_seconds(seconds);
  send_locked(std::move(response));
}

void FrameStream::OnReadDone(bool ok) {
  std::lock_guard lock(mutex_);
  reading_ = false;
  if (!ok) {
    read_all_ = true;
    return finish_if_idle_locked();
  }
  auto request = std::move(incoming_);
  try {
    if (!scene_) {
      if (!request->has_open()) throw FailedPrecondition("open", "the first request of a stream must be `open`");
      open_locked(request->open());
    } else {
      if (!request->has_frame()) throw FailedPrecondition("frame", "requests after the first must be `frame`");
      submit_locked(std::move(request));
    }
  } catch (...) {
    return finish_locked(to_status(describe_current()));
  }
  read_locked();
}

void FrameStream::open_locked(const pb::OpenStream& open) {
  check_open(open);
  window_ = grant_window(open.window(), max_window_);
  auto scene = scenes_.find(open.scene_id());
  if (!scene->snapshot().ready)
    throw FailedPrecondition("open.scene_id", fmt::format("scene {} still awaits triangles", scene->id()));
  scene_ = std::move(scene);
  Response response;
  fill_scene(*scene_, response.mutable_opened()->mutable_scene());
  response.mutable_opened()->set_window(window_);
  spdlog::info("scene {}: stream opened, window {}", scene_->id(), window_);
  send_locked(std::move(response));
}

void FrameStream::submit_locked(std::shared_ptr<Request> request) {
  ++in_flight_;
  const uint64_t frame_id = request->frame().frame_id();
  auto job = [self = shared_from_this(), request = std::move(request), arrival = std::chrono::steady_clock::now()] {
    self->work(*request, arrival);
  };
  if (scene_->worker().try_post(std::move(job))) return;
  // The refusal waits its turn, too, so that it does not pass the answers of earlier frames.
  scene_->worker().post([self = shared_from_this(), frame_id] { self->refuse_for_queue(frame_id); });
}

void FrameStream::refuse_for_queue(uint64_t frame_id) {
  std::lock_guard lock(mutex_);
  refuse_locked(frame_id,
                {grpc::StatusCode::RESOURCE_EXHAUSTED,
                 fmt::format("more than {} frames of several streams wait for this scene", max_window_), "frame"});
}

void FrameStream::work(const Request& request, Time arrival) {
  const uint64_t frame_id = request.frame().frame_id();
  try {
    answer(frame_id, run_frame(*scene_, {request.frame(), arrival, [this] { return cancelled_.load(); }}));
  } catch (...) {
    const Failure failure = describe_current();
    std::lock_guard lock(mutex_);
    ends_stream(failure) ? finish_locked(to_status(failure)) : refuse_locked(frame_id, failure);
  }
}

void FrameStream::answer(uint64_t frame_id, FrameAnswer answer) {
  std::lock_guard lock(mutex_);
  for (auto& chunk : answer.contacts) {
    Response response;
    response.set_frame_id(frame_id);
    *response.mutable_contacts() = std::move(chunk);
    send_locked(std::move(response));
  }
  Response response;
  response.set_frame_id(frame_id);
  *response.mutable_done() = std::move(answer.done);
  send_locked(std::move(response));
}

void FrameStream::refuse_locked(uint64_t frame_id, const Failure& failure) {
  spdlog::info("scene {} frame {}: refused: {}", scene_->id(), frame_id, failure.message);
  Response response;
  response.set_frame_id(frame_id);
  auto* error = response.mutable_error();
  error->set_code(failure.code);
  error->set_message(failure.message);
  error->set_field(failure.field);
  send_locked(std::move(response));
}

void FrameStream::read_locked() {
  if (reading_ || read_all_ || finished_ || (scene_ && in_flight_ >= window_)) return;
  if (queued_bytes_ > kMaxQueuedBytes) return;  // goes on when the client takes its answers
  reading_ = true;
  incoming_ = std::make_shared<Request>();
  StartRead(incoming_.get());
}

void FrameStream::send_locked(Response response) {
  if (finished_) return;
  queued_bytes_ += response.ByteSizeLong();
  outgoing_.push_back(std::move(response));
  write_locked();
}

void FrameStream::write_locked() {
  if (writing_ || finished_ || outgoing_.empty()) return;
  writing_ = true;
  StartWrite(&outgoing_.front());
}

void FrameStream::OnWriteDone(bool ok) {
  std::lock_guard lock(mutex_);
  writing_ = false;
  if (!ok) return finish_locked(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
  if (ends_frame(outgoing_.front())) --in_flight_;
  queued_bytes_ -= outgoing_.front().ByteSizeLong();
  outgoing_.pop_front();
  write_locked();
  read_locked();
  finish_if_idle_locked();
}

// Frames in the queue see the flag and stop; what they would answer is dropped.
void FrameStream::OnCancel() {
  cancelled_ = true;
  std::lock_guard lock(mutex_);
  finish_locked(grpc::Status(grpc::StatusCode::CANCELLED, "the call was cancelled"));
}

void FrameStream::finish_if_idle_locked() {
  if (read_all_ && in_flight_ == 0 && outgoing_.empty()) finish_locked(grpc::Status::OK);
}

void FrameStream::finish_locked(const grpc::Status& status) {
  if (finished_) return;
  finished_ = true;
  cancelled_ = true;
  spdlog::info("scene {}: stream ends: {}", scene_ ? scene_->id() : "-",
               status.ok() ? "complete" : status.error_message());
  Finish(status);
}

void FrameStream::OnDone() { self_.reset(); }

}  // namespace collided::server
