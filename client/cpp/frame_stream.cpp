// Frames in, contacts out: what callers do with a stream.

#include "client/cpp/frame_stream.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <utility>

#include "client/cpp/frame_stream_state.hpp"
#include "client/cpp/transport/features.hpp"

namespace collided::client {

void FrameOutput::check() const {
  if (!error) return;
  ErrorDetails details{.field = error->field()};
  if (error->retry_after_seconds() > 0) details.retry_after_seconds = error->retry_after_seconds();
  throw Error(error->code(), error->message(), std::move(details));
}

FrameStream::FrameStream(std::unique_ptr<State> state) : state_(std::move(state)) {}
FrameStream::FrameStream(FrameStream&&) noexcept = default;
FrameStream& FrameStream::operator=(FrameStream&&) noexcept = default;
FrameStream::~FrameStream() = default;

FrameStream FrameStream::open(std::unique_ptr<FrameTransport> transport, const v1::OpenStream& open,
                              StreamSetup setup) {
  if (setup.features) setup.features->check(open, "open");
  return FrameStream(std::make_unique<State>(std::move(transport), open, std::move(setup)));
}

const v1::Scene& FrameStream::scene() const { return state_->opened.scene(); }
bool FrameStream::is_local() const { return state_->setup.is_local; }
const std::string& FrameStream::local_refusal() const { return state_->setup.local_refusal; }
uint32_t FrameStream::window() const { return state_->opened.window(); }

std::optional<double> FrameStream::draining_deadline() const {
  const std::lock_guard lock(state_->mutex);
  if (!state_->draining) return std::nullopt;
  return std::max(0.0, std::chrono::duration<double>(*state_->draining - std::chrono::steady_clock::now()).count());
}

std::span<std::byte> FrameStream::input(uint64_t bytes) {
  {
    std::unique_lock lock(state_->mutex);
    state_->await_credit(lock);
  }
  return state_->transport->input(bytes);
}

void FrameStream::send(const v1::Frame& frame) { state_->send(frame, {}); }

void FrameStream::send(uint64_t frame_id, std::span<const FrameUpdate> updates, const FrameOptions& options) {
  state_->send(frame_head(frame_id, options), updates);
}

FrameOutput FrameStream::receive() {
  std::unique_lock lock(state_->mutex);
  if (state_->ready.empty() && state_->in_flight.empty() && !state_->ended)
    throw Error(grpc::FAILED_PRECONDITION, "receive() was called with no frame in flight");
  state_->await(lock, [&] { return state_->has_news(); });
  return state_->take_ready();
}

std::optional<FrameOutput> FrameStream::receive_within(std::chrono::milliseconds timeout) {
  std::unique_lock lock(state_->mutex);
  const auto deadline = time_after(timeout);
  if (!state_->await(
          lock, [&] { return state_->has_news(); }, deadline))
    return std::nullopt;
  return state_->take_ready();
}

void FrameStream::finish() {
  std::unique_lock lock(state_->mutex);
  if (!std::exchange(state_->half_closed, true)) {
    lock.unlock();
    state_->transport->half_close();
    lock.lock();
  }
  state_->await_end(lock);
  if (state_->failure) throw *state_->failure;
}

void FrameStream::cancel() {
  const std::lock_guard lock(state_->mutex);
  if (!state_->ended) state_->transport->cancel();
}

bool FrameStream::has_ended() const {
  const std::lock_guard lock(state_->mutex);
  return state_->ended;
}

}  // namespace collided::client
