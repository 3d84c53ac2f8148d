// Reads answers, assembles each frame's chunks and counts credits. The thread that waits for an answer reads it itself:
// on an idle CPU, waking another thread for it costs as much as the transport.

#include "client/cpp/frame_stream_state.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <functional>
#include <utility>

namespace collided::client {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kMaxTime(1'000'000'000);  // longer ones overflow the clock

template <class Values>
auto& value_of(Values& values, v1::ContactKind wanted) {
  auto* found = &values.vertex_triangle;
  bool is_known = false;
  for_each_kind(
      [&](v1::ContactKind kind, auto& value) {
        if (kind == wanted) found = &value, is_known = true;
      },
      values);
  if (is_known) return *found;
  throw Error(grpc::DATA_LOSS, "contacts.kind is " + std::to_string(wanted) + ", which this client does not know");
}

void add(FrameOutput& output, const v1::ContactChunk& chunk, const FrameTransport& transport) {
  if (chunk.has_shared() && transport.device_output_bytes() > 0)
    value_of(output.on_device, chunk.kind()) = on_device(chunk, transport.device_output_bytes());
  else
    append(value_of(output, chunk.kind()), chunk, &transport);
}

}  // namespace

FrameTransport::Time time_after(std::chrono::duration<double> time) {
  const double kept = time.count() > 0 ? std::min<double>(time.count(), kMaxTime.count()) : 0;
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kept));
}

FrameStream::State::State(std::unique_ptr<FrameTransport> fresh, const v1::OpenStream& open, StreamSetup of_stream)
    : setup(std::move(of_stream)), transport(std::move(fresh)) {
  v1::StreamFramesResponse response;
  const bool is_answered =
      transport->open(open) && transport->read(response, FrameTransport::kNever) == FrameTransport::Arrival::kMessage;
  if (!is_answered || !response.has_opened()) {
    if (is_answered) transport->cancel();
    const std::optional<Error> end = transport->finish();
    if (!is_answered && end) throw *end;
    throw Error(grpc::INTERNAL, "the daemon's first answer does not open the stream");
  }
  opened = std::move(*response.mutable_opened());
  keeper = std::thread([this] { run_keeper(); });
}

FrameStream::State::~State() {
  {
    const std::lock_guard lock(mutex);
    is_stopping = true;
    if (!ended) transport->cancel();
  }
  stop.notify_one();
  keeper.join();
  std::unique_lock lock(mutex);
  await(lock, [&] { return ended; });
}

bool FrameStream::State::read_one(std::unique_lock<std::mutex>& lock, FrameTransport::Time deadline) {
  using Arrival = FrameTransport::Arrival;
  lock.unlock();
  v1::StreamFramesResponse response;
  auto arrival = Arrival::kNothing;
  std::optional<Error> malformed;
  try {
    arrival = transport->read(response, deadline);
    if (arrival == Arrival::kMessage) take(response);
  } catch (const Error& e) {  // the stream can no longer be trusted
    malformed = e;
  } catch (const std::exception& e) {
    malformed = Error(grpc::INTERNAL, std::string("an answer could not be taken: ") + e.what());
  }
  if (malformed) transport->cancel();
  const bool is_end = malformed || arrival == Arrival::kEnd;
  std::optional<Error> why = is_end ? transport->finish() : std::nullopt;
  lock.lock();
  if (is_end) {
    failure = malformed ? std::move(malformed) : std::move(why);
    ended = true;
  }
  return is_end || arrival == Arrival::kMessage;
}

void FrameStream::State::run_keeper() {
  std::unique_lock lock(mutex);
  for (int quiet_pauses = 0; !ended && !is_stopping;) {
    const uint64_t seen = waits;
    stop.wait_until(lock, time_after(setup.keeper.pause), [&] { return is_stopping; });
    const auto is_alone = [&] { return !ended && !is_stopping && waiting == 0 && waits == seen; };
    quiet_pauses = is_alone() ? quiet_pauses + 1 : 0;
    while (is_alone() &&
           reading.lead_once(lock, keeper_deadline(quiet_pauses), std::bind_front(&State::read_one, this)))
      continue;
  }
}

/// A caller that comes while the keeper reads must be woken by it. So the keeper reads only briefly while callers come
/// and go, and without a deadline once none has waited for a while.
FrameTransport::Time FrameStream::State::keeper_deadline(int quiet_pauses) const {
  if (quiet_pauses >= setup.keeper.quiet_pauses) return FrameTransport::kNever;
  return in_flight > 0 ? time_after(setup.keeper.pause) : Clock::now();
}

void FrameStream::State::take(v1::StreamFramesResponse& response) {
  const uint64_t id = response.frame_id();
  switch (response.response_case()) {
    case v1::StreamFramesResponse::kContacts:
      return add(partial[id], response.contacts(), *transport);
    case v1::StreamFramesResponse::kDone:
      for (const v1::ContactChunk& chunk : response.done().contacts()) add(partial[id], chunk, *transport);
      response.mutable_done()->clear_contacts();
      partial[id].done = std::move(*response.mutable_done());
      return complete(id);
    case v1::StreamFramesResponse::kWorldErrors:
      for (v1::WorldError& error : *response.mutable_world_errors()->mutable_errors())
        partial[id].world_errors.push_back(std::move(error));
      return;
    case v1::StreamFramesResponse::kError:
      partial[id].error = std::move(*response.mutable_error());
      return complete(id);
    case v1::StreamFramesResponse::kSkipped:
      partial[id].skipped = true;
      return complete(id);
    case v1::StreamFramesResponse::kDraining: {
      const std::lock_guard lock(mutex);
      draining = time_after(std::chrono::duration<double>(response.draining().deadline_seconds()));
      return;  // frames in flight are still answered
    }
    default:
      return;
  }
}

void FrameStream::State::complete(uint64_t frame_id) {
  FrameOutput output = std::move(partial[frame_id]);
  partial.erase(frame_id);
  output.frame_id = frame_id;
  {
    const std::lock_guard lock(mutex);
    ready.push_back(std::move(output));
    if (in_flight > 0) --in_flight;
  }
  reading.notify();
}

void FrameStream::State::throw_ended() const {
  if (failure) throw *failure;
  if (half_closed) throw Error(grpc::FAILED_PRECONDITION, "the stream has ended, as finish() asked for");
  throw Error(grpc::UNAVAILABLE, "the stream has ended");
}

FrameOutput FrameStream::State::take_ready() {
  if (ready.empty()) throw_ended();
  FrameOutput output = std::move(ready.front());
  ready.pop_front();
  return output;
}

void FrameStream::State::await_credit(std::unique_lock<std::mutex>& lock) {
  await(lock, [&] { return ended || in_flight < opened.window(); });
  if (ended) throw_ended();
}

void FrameStream::State::take_credit() {
  std::unique_lock lock(mutex);
  await_credit(lock);
  ++in_flight;
}

void FrameStream::State::give_credit() {
  const std::lock_guard lock(mutex);
  --in_flight;
  reading.notify();
}

void FrameStream::State::send(const v1::Frame& frame, std::span<const FrameUpdate> updates) {
  take_credit();
  try {
    if (transport->send(frame, updates)) return;
  } catch (const Error&) {  // nothing was sent
    give_credit();
    throw;
  }
  std::unique_lock lock(mutex);
  await(lock, [&] { return ended; });  // then its reason is known
  throw_ended();
}

}  // namespace collided::client
