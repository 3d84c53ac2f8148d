// One StreamFrames call.
#include "server/transport/grpc/frame_call.hpp"

#include <grpcpp/support/proto_buffer_reader.h>

#include <algorithm>
#include <new>
#include <thread>
#include <utility>

#include "server/errors.hpp"
#include "server/frames/answer.hpp"
#include "server/frames/log.hpp"
#include "server/frames/messages.hpp"
#include "server/transport/grpc/request_call.hpp"

namespace collided::server {
namespace {

constexpr StreamKind kKind{"stream", "StreamFrames"};
constexpr size_t kMaxOutgoing = size_t{16} << 20;   // bytes of unsent answers past which no frame is started
constexpr auto kLinger = std::chrono::seconds(10);  // for the last message if the client does not take it
constexpr size_t kAlignmentBytes = 4096;            // for the alignment of each update's positions

}  // namespace

FrameCall::Tag* FrameCall::Tag::send() {
  alive_ = call_.shared_from_this();
  return this;
}

void FrameCall::Tag::arrive(bool ok) {
  const auto alive = std::exchange(alive_, nullptr);
  (call_.*arrival_)(ok);
}

void FrameCall::Tag::drop() { alive_.reset(); }

void FrameCall::accept(FrameCalls& calls) {
  const std::shared_ptr<FrameCall> call(new FrameCall(calls));
  call->context_.AsyncNotifyWhenDone(call->gone_.send());
  calls.service_.RequestStreamFrames(&call->context_, &call->stream_, calls.queue_.get(), calls.queue_.get(),
                                     call->accepted_.send());
}

// Waits until there is memory for it: without it fewer and fewer calls could be accepted.
void FrameCall::accept_next(FrameCalls& calls) {
  constexpr auto kPoll = std::chrono::milliseconds(10);
  for (;;) try {
      return accept(calls);
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(kPoll);
    }
}

void FrameCall::on_accepted(bool ok) {
  if (!ok) return gone_.drop();  // the server shuts down, and its tag will not arrive
  accept_next(calls_);
  calls_.parts_.events.on_accepted(context_);
  caller_.ids = ids_of(context_.client_metadata());  // even for a call that is refused
  try {
    calls_.add(shared_from_this());
    caller_.client = identify(context_, calls_.parts_.authenticator).client;
    host_.check_serving();
    await_opening();
  } catch (...) {
    return fail();
  }
  const std::lock_guard lock(mutex_);
  read_locked();
}

// Each connection may have as many waiting as its client may have open: a client that opens at once is never evicted by
// those that never open.
void FrameCall::await_opening() {
  const Limits limits = host_.limits();
  const WaitRule rule{"the opening of a stream", limits.max_silent_seconds, limits.max_streams,
                      caller_.client->limits.max_streams, context_.peer()};
  auto wait = calls_.parts_.waiting.wait(rule, caller_.client, [weak = weak_from_this()](const auto& why) {
    if (const auto call = weak.lock()) call->ended(why);
  });
  const std::lock_guard lock(mutex_);
  opening_ = std::move(wait);
}

void FrameCall::on_read(bool ok) {
  grpc::ByteBuffer bytes;
  {
    const std::lock_guard lock(mutex_);
    if (status_) return;
    if (!ok) {
      flow_.half_close();
      return end_if_complete_locked();
    }
    bytes.Swap(&incoming_);
  }
  if (bytes.Length() <= kMaxUnsharedBytes) return handle(bytes);
  calls_.parts_.work.post(caller_.client->turn_path(), [self = shared_from_this(), bytes] { self->handle(bytes); });
}

void FrameCall::handle(const grpc::ByteBuffer& bytes) {
  try {
    take(bytes);
  } catch (...) {
    return fail();
  }
  const std::lock_guard lock(mutex_);
  is_reading_ = false;  // only now, as messages are handled one at a time
  read_locked();
}

void FrameCall::take(const grpc::ByteBuffer& bytes) {
  check_message_size(bytes.Length(), calls_.parts_.max_message_bytes);
  if (session_) session_->scene().worker().wake_early();
  IncomingFrame incoming;
  auto request = decode(bytes, incoming);
  if (!session_) {
    if (!request.message.has_open()) throw FailedPrecondition("open", "the first request of a stream must be `open`");
    return open(request.message.open());
  }
  if (!request.message.has_frame()) throw FailedPrecondition("frame", "requests after the first must be `frame`");
  incoming.message = std::move(*request.message.mutable_frame());
  incoming.placed = std::move(request.placed);
  if (request.refusal) incoming.refusal = request.refusal;
  submit(std::move(incoming));
}

Expected FrameCall::expected() const {
  if (!session_) return {};
  const auto plan = session_->scene().plan();
  return {plan->meshes.size(), plan->engine.worlds};
}

// Positions go straight to a slot. Without one the frame is still decoded, so that it can be refused by its id.
DecodedRequest FrameCall::decode(const grpc::ByteBuffer& bytes, IncomingFrame& incoming) const {
  grpc::ByteBuffer copy(bytes);  // copies references only
  grpc::ProtoBufferReader reader(&copy);
  return decode_request(reader, bytes.Length(), expected(), [&]() -> std::span<std::byte> {
    try {
      incoming.slot = session_->scene().engine().take_slot();
      const uint64_t max = max_position_bytes(session_->scene().plan()->engine);
      return incoming.slot->room(std::min<uint64_t>(bytes.Length(), max) + kAlignmentBytes);
    } catch (...) {
      incoming.refusal = std::current_exception();
      return {};
    }
  });
}

void FrameCall::open(const pb::OpenStream& open) {
  const StreamTerms terms = parse_open(open, host_.limits());
  auto scene = host_.scenes().find(caller_.client, open.scene_id());
  take_ticket(*scene, open.resume_token(), terms.window);
  auto session =
      FrameSession::open(std::move(scene), open.resume_token(), terms.delivery, shared_from_this(), caller_.ids);
  {
    const std::lock_guard lock(mutex_);
    session_ = session;
    if (status_) session->close();  // ended in the meantime
  }
  session->scene().engine().charge_to(caller_.client->turn_path());
  host_.tell_of_stop(*session);
  log_stream_opened(kKind, session->scene(), terms.window, caller_.ids);
}

// From now on the call counts as one of the client's streams, not as a waiting call.
void FrameCall::take_ticket(const Scene& scene, const std::string& resume_token, uint32_t window) {
  auto ticket = host_.begin_stream(caller_.client, scene, resume_token);
  const std::lock_guard lock(mutex_);
  opening_.reset();
  flow_.open(window);
  if (!status_) ticket_ = std::move(ticket);
}

void FrameCall::submit(IncomingFrame incoming) {
  incoming.answer_bytes_per_contact = session_->scene().plan()->fields.made_bytes();
  PendingFrame frame = admit_frame(host_, session_->scene(), std::move(incoming));
  {
    const std::lock_guard lock(mutex_);
    flow_.submit(frame.frame_id, frame.input.edit != nullptr);
  }
  session_->submit(std::move(frame));
}

// The message counts against the scene's quota: with many meshes it is long, and the client may not take it.
void FrameCall::opened(const Scene& scene) try {
  std::vector<EncodedMessage> messages;
  messages.push_back(encode(opened_message(scene, flow_.window())));
  const auto held = std::make_shared<MemoryHold>(scene.quota());
  held->resize(messages.front().size);
  messages.front().held = held;
  send(std::move(messages));
  const std::lock_guard lock(mutex_);
  flow_.opened();
  end_if_complete_locked();
} catch (...) {
  fail();
}

void FrameCall::answered(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame) {
  take_outcome(frame->frame_id);
  send(encode_answer(scene, frame, kMaxChunkBytes));
}

void FrameCall::refused(uint64_t frame_id, const Failure& failure) {
  take_outcome(frame_id);
  send(refusal_message(frame_id, failure));
}

// The next frame is read once the message about this one has gone.
void FrameCall::take_outcome(uint64_t frame_id) {
  const std::lock_guard lock(mutex_);
  flow_.answer(frame_id);
}

void FrameCall::skipped(uint64_t frame_id) { send(skipped_message(frame_id)); }

void FrameCall::draining(double seconds) { send(draining_message(seconds)); }

void FrameCall::ended(const std::exception_ptr& why) {
  const std::lock_guard lock(mutex_);
  end_locked(to_status(describe(why)));
}

void FrameCall::fail() { ended(std::current_exception()); }

void FrameCall::end_unopened() {
  const std::lock_guard lock(mutex_);
  if (!session_) end_locked(to_status(describe(std::make_exception_ptr(Stopping()))));
}

uint64_t FrameCall::outgoing_bytes() const {
  const std::lock_guard lock(mutex_);
  return outgoing_bytes_;
}

void FrameCall::read_locked() {
  if (is_reading_ || !flow_.may_read()) return;
  is_reading_ = true;
  stream_.Read(&incoming_, read_.send());
}

void FrameCall::send(const pb::StreamFramesResponse& response) {
  std::vector<EncodedMessage> messages;
  messages.push_back(encode(response));
  send(std::move(messages));
}

void FrameCall::send(std::vector<EncodedMessage> messages) {
  const std::lock_guard lock(mutex_);
  if (status_) return;
  for (auto& message : messages) {
    outgoing_bytes_ += message.size;
    outgoing_.push_back(std::move(message));
  }
  if (session_ && outgoing_bytes_ > kMaxOutgoing) session_->hold(true);
  write_locked();
}

void FrameCall::write_locked() {
  if (is_writing_ || outgoing_.empty()) return;
  is_writing_ = true;
  grpc::WriteOptions options;
  if (outgoing_.size() > 1) options.set_buffer_hint();
  stream_.Write(outgoing_.front().bytes, options, written_.send());
}

void FrameCall::on_written(bool ok) {
  const std::lock_guard lock(mutex_);
  is_writing_ = false;
  if (status_) return finish_locked();
  if (!ok) return end_locked(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
  if (outgoing_.front().ends_frame) flow_.release();
  outgoing_bytes_ -= outgoing_.front().size;
  outgoing_.pop_front();
  if (session_) session_->hold(outgoing_bytes_ > kMaxOutgoing);
  write_locked();
  read_locked();
  end_if_complete_locked();
}

// Arrives for every call that was accepted. If it was cancelled, waiting and running frames notice, and stop. Until
// then a client that has half-closed looks like one that is gone.
void FrameCall::on_gone(bool) {
  const std::lock_guard lock(mutex_);
  const bool is_cancelled = context_.IsCancelled();
  if (is_cancelled) {
    end_locked(grpc::Status(grpc::StatusCode::CANCELLED, "the call was cancelled"));
    abandon_locked();
  }
  if (status_ && status_->ok())
    tell_end(is_cancelled ? grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone") : grpc::Status::OK);
}

void FrameCall::end_if_complete_locked() {
  if (flow_.is_complete() && outgoing_.empty()) end_locked(grpc::Status::OK);
}

// Drops unsent messages: a client that resumes is told the last frame that was applied.
void FrameCall::end_locked(const grpc::Status& status) {
  if (status_) return;
  status_ = status;
  flow_.end();
  if (!status.ok()) tell_end(status);  // else once it is known whether the client is still there
  if (session_) session_->close();
  if (status.ok() || status.error_code() == grpc::StatusCode::CANCELLED) abandon_locked();
  opening_.reset();
  ticket_.reset();
  finish_locked();
}

// Counts a call that opened no stream, unless its client waits for the refusal.
void FrameCall::abandon_locked() {
  if (!session_ && !std::exchange(is_abandoned_, true)) calls_.parts_.events.on_abandoned(context_.peer());
}

// A pending write has to complete before the status is sent.
void FrameCall::finish_locked() {
  drop_outgoing_locked();
  if (is_writing_)
    return linger_.Set(calls_.queue_.get(), std::chrono::system_clock::now() + kLinger, lingered_.send());
  if (std::exchange(is_finishing_, true)) return;
  linger_.Cancel();
  stream_.Finish(*status_, finished_.send());
}

// Keeps the message whose write is pending.
void FrameCall::drop_outgoing_locked() {
  outgoing_.erase(outgoing_.begin() + (is_writing_ ? 1 : 0), outgoing_.end());
  outgoing_bytes_ = is_writing_ ? outgoing_.front().size : 0;
}

void FrameCall::on_linger(bool ok) {
  if (ok) context_.TryCancel();
}

void FrameCall::tell_end(const grpc::Status& status) const {
  tell_stream_ended(kKind,
                    {.scene = session_ ? session_->scene().id() : std::string_view(),
                     .code = status.error_code(),
                     .reason = status.error_message()},
                    caller_.ids, calls_.parts_.metrics);
}

}  // namespace collided::server
