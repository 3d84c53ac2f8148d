// Sends frames, matches answers to them, and starts over after a loss.

#include "client/cpp/session/session_state.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <utility>

#include "client/cpp/frame_stream_state.hpp"

namespace collided::client {

namespace {

constexpr std::chrono::duration<double> kLeavePause(1);

/// Calls without the lock, and takes it again.
template <class Call>
auto unlocked(std::unique_lock<std::mutex>& lock, const Call& call) {
  struct Relock {
    explicit Relock(std::unique_lock<std::mutex>& held) : lock(held) { lock.unlock(); }
    ~Relock() { lock.lock(); }
    std::unique_lock<std::mutex>& lock;
  } relock(lock);
  return call();
}

Error closed(int code, const std::string& what) { return {code, "the session is closed" + what}; }

Error gave_up(const Error& last, uint32_t attempts) {
  return {
      last.code(), "the session gave up (attempts to reconnect: " + std::to_string(attempts) + "): " + last.message(),
      ErrorDetails{.field = last.field(), .quota = last.quota(), .retry_after_seconds = last.retry_after_seconds()}};
}

/// Callers' functions must not throw: nobody could take it, and the frame has its answer.
void tell(const FrameInFlight& frame, FrameResult result) noexcept { frame.done(std::move(result)); }

void fail(const FrameInFlight& frame, const Error& error) { tell(frame, {frame.number, error}); }

std::optional<Error> refusal_of(const FrameOutput& output) try {
  output.check();
  return std::nullopt;
} catch (const Error& refusal) {
  return refusal;
}

void answer(const FrameInFlight& frame, FrameOutput output) {
  if (const auto refusal = refusal_of(output)) return fail(frame, *refusal);
  tell(frame, {frame.number, std::move(output)});
}

/// The error of a frame that the stream cannot carry; none if it was sent, or if the stream has ended, which the
/// receiver notices.
std::optional<Error> try_send(FrameStream& stream, const FrameInFlight& frame) try {
  stream.send(frame.wire_id, frame.frame.views(), frame.frame.options);
  return std::nullopt;
} catch (const Error& e) {
  return stream.has_ended() ? std::nullopt : std::optional(e);
} catch (const std::exception& e) {
  return Error(grpc::RESOURCE_EXHAUSTED, std::string("the frame could not be sent: ") + e.what());
}

}  // namespace

Session::State::State(ChannelFactory channels, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
                      const SessionOptions& options)
    : connector(std::move(channels), spec, meshes, options),
      memory(connector.input().spec(), connector.input().meshes()) {
  Connector::Opened opened = connector.create();
  scene = std::move(opened.scene);
  stream.emplace(std::move(opened.stream));
  window = stream->window();
}

std::shared_ptr<Session::State> Session::State::begin(ChannelFactory channels, const v1::SceneSpec& spec,
                                                      std::span<const MeshInput> meshes,
                                                      const SessionOptions& options) {
  auto state = std::make_shared<State>(std::move(channels), spec, meshes, options);
  const Lock lock(state->mutex);  // which the receiver waits for
  state->receiver = std::thread([state] { state->run(); });
  state->receiver_id = state->receiver.get_id();
  return state;
}

// The receiver makes places, and so cannot wait for one. A function that is called meanwhile may destroy the session.
void Session::State::submit(OwnedFrame frame, Done done) {
  const auto self = shared_from_this();
  Lock lock(mutex);
  if (!is_own_thread()) changed.wait(lock, [&] { return is_closed || frames.size() < window; });
  if (is_closed) throw closed(grpc::FAILED_PRECONDITION, "");
  frames.push_back({++last_number, 0, std::move(frame), std::move(done)});
  changed.notify_all();
  if (is_ready && sending == 0) send_unsent(lock);
}

void Session::State::send_unsent(Lock& lock) {
  const auto is_unsent = [](const FrameInFlight& frame) { return frame.wire_id == 0; };
  for (;;) {
    const auto next = std::find_if(frames.begin(), frames.end(), is_unsent);
    if (next == frames.end() || !is_ready || is_leaving || is_closed) return;
    sending = next->wire_id = ++last_wire_id;
    const std::optional<Error> refusal = unlocked(lock, [&] { return try_send(*stream, *next); });
    sending = 0;
    changed.notify_all();
    if (!refusal) continue;
    std::list<FrameInFlight> refused;
    refused.splice(refused.end(), frames, next);
    unlocked(lock, [&] { fail(refused.front(), *refusal); });
  }
}

void Session::State::run() {
  Lock lock(mutex);
  for (;;) {
    changed.wait(lock, [&] { return is_closed || !frames.empty(); });
    if (is_closed) break;
    try {
      if (!is_ready)
        reopen(lock);
      else
        is_leaving&& frames.front().wire_id == 0 ? leave(lock) : receive_one(lock);
    } catch (const Error& e) {
      lose(lock, e);
    } catch (const std::exception& e) {
      lose(lock, Error(grpc::RESOURCE_EXHAUSTED, std::string("an answer could not be taken: ") + e.what()));
    }
  }
  changed.wait(lock, [&] { return sending == 0; });
  fail_all(lock, closed(grpc::CANCELLED, "; the frame was not answered"));
}

void Session::State::receive_one(Lock& lock) {
  FrameOutput output = unlocked(lock, [&] { return connector.receive(*stream); });
  if (frames.empty() || frames.front().wire_id != output.frame_id)
    throw Error(grpc::DATA_LOSS, "the daemon answered frame " + std::to_string(output.frame_id) + " out of order");
  FrameInFlight& frame = frames.front();
  changed.wait(lock, [&] { return sending != frame.wire_id; });  // its memory is still read
  if (!output.error && !output.skipped) memory.apply(std::move(frame.frame), output);
  output.frame_id = frame.number;
  trouble.reset();
  std::list<FrameInFlight> answered;
  answered.splice(answered.end(), frames, frames.begin());
  is_leaving = stream->draining_deadline() && std::chrono::steady_clock::now() >= next_leave;
  changed.notify_all();
  unlocked(lock, [&] { answer(answered.front(), std::move(output)); });
}

void Session::State::leave(Lock& lock) {
  next_leave = time_after(kLeavePause);
  if (std::optional<Connector::Opened> opened = unlocked(lock, [&] { return connector.leave(scene); })) {
    scene = std::move(opened->scene);
    ++recreations;
    stream.emplace(std::move(opened->stream));
    last_wire_id = unlocked(lock, [&] { return connector.restore(*stream, memory); });
  }
  is_leaving = false;
  send_unsent(lock);
}

void Session::State::lose(Lock& lock, const Error& error) {
  if (stream) stream->cancel();
  is_ready = is_leaving = false;
  changed.wait(lock, [&] { return sending == 0; });
  stream.reset();
  for (FrameInFlight& frame : frames) frame.wire_id = 0;
  if (is_closed) return;
  may_pass(error) ? wait_for_next_attempt(lock, error) : fail_all(lock, error);
}

/// The first attempt after a loss is made at once.
void Session::State::wait_for_next_attempt(Lock& lock, const Error& error) {
  const SessionOptions& options = connector.options();
  if (!trouble) trouble = Trouble{time_after(options.give_up), options.first_pause, 0};
  const double asked = error.retry_after_seconds().value_or(0),
               pause = trouble->attempts == 0 ? 0 : std::chrono::duration<double>(trouble->pause).count();
  const auto next = time_after(std::chrono::duration<double>(std::max(asked, pause)));
  const bool is_last = options.max_attempts > 0 && trouble->attempts == options.max_attempts;
  if (is_last || next >= trouble->deadline) return fail_all(lock, gave_up(error, trouble->attempts));
  changed.wait_until(lock, next, [&] { return is_closed; });
  if (trouble->attempts++ > 0) trouble->pause = std::min(trouble->pause * 2, options.longest_pause);
}

void Session::State::reopen(Lock& lock) {
  if (!trouble) trouble = Trouble{time_after(connector.options().give_up), connector.options().first_pause, 1};
  Connector::Opened opened =
      unlocked(lock, [&] { return connector.reopen(scene, memory.first() != nullptr, trouble->deadline); });
  scene = std::move(opened.scene);
  recreations += opened.is_new ? 1 : 0;
  stream.emplace(std::move(opened.stream));
  if (is_closed) return;
  last_wire_id = unlocked(lock, [&] { return connector.restore(*stream, memory); });
  is_ready = true;
  ++reconnects;
  send_unsent(lock);
}

void Session::State::fail_all(Lock& lock, const Error& error) {
  std::list<FrameInFlight> failed = std::exchange(frames, {});
  trouble.reset();
  changed.notify_all();
  unlocked(lock, [&] {
    for (FrameInFlight& frame : failed) fail(frame, error);
  });
}

bool Session::State::stop() {
  Lock lock(mutex);
  if (std::exchange(is_closed, true)) return false;
  if (stream) stream->cancel();
  changed.notify_all();
  lock.unlock();
  if (!is_own_thread()) receiver.join();
  return true;
}

void Session::State::end() {
  stop();
  if (!receiver.joinable()) return;
  is_own_thread() ? receiver.detach() : receiver.join();
}

}  // namespace collided::client
