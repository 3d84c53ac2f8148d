// Reads answers, assembles each frame's chunks and counts credits. The thread that waits for an answer reads it itself:
// on an idle CPU, waking another thread for it costs as much as the transport.

#include "client/cpp/frame_stream_state.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "client/cpp/transport/features.hpp"

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

constexpr uint32_t kMaxWindow = 1024;  // of any daemon

[[noreturn]] void throw_lost(const std::string& what) { throw Error(grpc::DATA_LOSS, what); }

void check_fraction(const char* field, double value) {
  if (!(value >= 0 && value <= 1))
    throw_lost(std::string("done.") + field + " is " + std::to_string(value) + "; it must be in [0, 1]");
}

void check_opened(const v1::StreamOpened& opened, const v1::OpenStream& open) {
  const uint32_t most = open.window() ? open.window() : kMaxWindow;
  if (opened.window() < 1 || opened.window() > most)
    throw_lost("opened.window is " + std::to_string(opened.window()) + "; it must be from 1 to " +
               std::to_string(most));
  if (opened.scene().scene_id() != open.scene_id())
    throw_lost("the daemon opened scene '" + opened.scene().scene_id() + "' instead of '" + open.scene_id() + "'");
}

std::string text_of(std::chrono::milliseconds limit) { return std::to_string(limit.count()) + " ms (deadline)"; }

}  // namespace

FrameTransport::Time time_after(std::chrono::duration<double> time) {
  const double kept = time.count() > 0 ? std::min<double>(time.count(), kMaxTime.count()) : 0;
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kept));
}

FrameStream::State::State(std::unique_ptr<FrameTransport> fresh, const v1::OpenStream& open, StreamSetup of_stream)
    : setup(std::move(of_stream)),
      may_skip(open.delivery() == v1::DELIVERY_POLICY_LATEST_WINS),
      transport(std::move(fresh)) {
  using Arrival = FrameTransport::Arrival;
  v1::StreamFramesResponse response;
  auto arrival = Arrival::kEnd;
  try {
    if (transport->open(open)) arrival = transport->read(response, time_after(setup.deadline));
    if (arrival == Arrival::kNothing)
      throw Error(grpc::DEADLINE_EXCEEDED,
                  "the daemon at " + setup.address + " did not open the stream within " + text_of(setup.deadline));
    if (arrival == Arrival::kMessage) {
      if (!response.has_opened()) throw_lost("the daemon's first answer does not open the stream");
      check_opened(response.opened(), open);
    }
  } catch (const Error&) {
    transport->cancel();
    if (arrival == Arrival::kNothing) transport->read(response, FrameTransport::kNever);  // a read is pending
    transport->finish();
    throw;
  }
  if (arrival == Arrival::kEnd) {
    const std::optional<Error> end = transport->finish();
    throw end ? *end : Error(grpc::UNAVAILABLE, "the daemon ended the stream before it was open");
  }
  opened = std::move(*response.mutable_opened());
  size = size_of(opened.scene().spec());
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
  return !in_flight.empty() ? time_after(setup.keeper.pause) : Clock::now();
}

void FrameStream::State::take(v1::StreamFramesResponse& response) {
  if (response.has_draining()) {
    const std::lock_guard lock(mutex);
    draining = time_after(std::chrono::duration<double>(response.draining().deadline_seconds()));
    return;  // frames in flight are still answered
  }
  if (response.response_case() == v1::StreamFramesResponse::RESPONSE_NOT_SET) return;  // of a later version
  const uint64_t id = response.frame_id();
  const SentFrame sent = next_answered(id);
  partial.advance.mode = sent.advance_mode;
  takes_limits = sent.limits;
  switch (response.response_case()) {
    case v1::StreamFramesResponse::kContacts:
      return add(response.contacts());
    case v1::StreamFramesResponse::kShortened:
      return add(response.shortened());
    case v1::StreamFramesResponse::kPairs:
      return add(response.pairs());
    case v1::StreamFramesResponse::kLimits:
      return add_limits(response.limits());
    case v1::StreamFramesResponse::kDone:
      finish_frame(*response.mutable_done());
      return complete(id);
    case v1::StreamFramesResponse::kWorldErrors:
      for (v1::WorldError& error : *response.mutable_world_errors()->mutable_errors()) {
        if (!partial.world_errors.empty() && error.world() <= partial.world_errors.back().world())
          throw_lost("world_errors names world " + std::to_string(error.world()) + " after a later one");
        partial.world_errors.push_back(std::move(error));
      }
      return;
    case v1::StreamFramesResponse::kError:
      partial.error = std::move(*response.mutable_error());
      return complete(id);
    case v1::StreamFramesResponse::kSkipped:
      if (!may_skip)
        throw_lost("the daemon skipped frame " + std::to_string(id) + " of a stream that answers each one");
      partial.skipped = true;
      return complete(id);
    default:
      throw_lost("the daemon answers frame " + std::to_string(id) + " with what is no answer");
  }
}

SentFrame FrameStream::State::next_answered(uint64_t frame_id) {
  const std::lock_guard lock(mutex);
  if (in_flight.empty() || in_flight.front().id != frame_id)
    throw_lost("the daemon answers frame " + std::to_string(frame_id) + ", which is not the oldest in flight");
  return in_flight.front();
}

void FrameStream::State::add(const v1::ContactChunk& chunk) {
  if (chunk.has_shared() && transport->device_output_bytes() > 0) {
    value_of(partial.on_device, chunk.kind()) = on_device(chunk, transport->device_output_bytes());
    return;
  }
  Contacts& contacts = value_of(partial, chunk.kind());
  const uint64_t before = contacts.count;
  append(contacts, chunk, transport.get());
  check(chunk.kind(), contacts, before);
}

void FrameStream::State::add_limits(const v1::ContactChunk& chunk) {
  if (!takes_limits) throw_lost("the daemon names limits of a frame that does not ask for them");
  Contacts& limits = value_of(partial.limits, chunk.kind());
  if (chunk.kind() != v1::CONTACT_KIND_VERTEX_TRIANGLE && chunk.kind() != v1::CONTACT_KIND_EDGE_EDGE)
    throw_lost("limits.kind is " + v1::ContactKind_Name(chunk.kind()) + ", which limits no way");
  const uint64_t before = limits.count;
  append(limits, chunk);
  for_each_column([&](v1::ContactField field, auto column) {
    const bool has_field = (limits.*column).size() == limits.count;
    const bool is_of_dcd = field == v1::CONTACT_FIELD_FEATURES || field == v1::CONTACT_FIELD_SIGNED_DISTANCE;
    if (!has_field && !is_of_dcd)
      throw_lost("limits has no " + v1::ContactField_Name(field) + "; it must have all fields");
  });
  check(chunk.kind(), limits, before);
}

void FrameStream::State::check(v1::ContactKind kind, const Contacts& contacts, uint64_t first) {
  const std::lock_guard lock(mutex);
  if (size.vertices > 0 && !has_edits) check_ids(kind, contacts, first, size);
}

void FrameStream::State::add(const v1::ShortenedWays& ways) {
  constexpr uint64_t kAnyId = uint64_t{1} << 32;
  const v1::AdvanceMode mode = partial.advance.mode;
  if (mode == v1::ADVANCE_MODE_ALL_OR_ONE)
    throw_lost("the daemon names shortened ways of a frame that does not advance per mesh or per vertex");
  uint64_t id_count = kAnyId;
  {
    const std::lock_guard lock(mutex);
    if (size.vertices > 0 && !has_edits) id_count = mode == v1::ADVANCE_MODE_PER_MESH ? size.meshes : size.vertices;
  }
  append(partial.advance, ways, id_count);
}

void FrameStream::State::add(const v1::MeshPairs& pairs) {
  SceneSize known;
  {
    const std::lock_guard lock(mutex);
    if (!has_edits) known = size;
  }
  append(partial.pairs, pairs, known);
}

void FrameStream::State::finish_frame(v1::FrameDone& done) {
  for (const v1::ContactChunk& chunk : done.contacts()) add(chunk);
  for (const v1::ContactChunk& chunk : done.limits()) add_limits(chunk);
  if (done.has_shortened()) add(done.shortened());
  if (done.has_pairs()) add(done.pairs());
  done.clear_contacts();
  done.clear_limits();
  done.clear_shortened();
  done.clear_pairs();
  check_fraction("earliest_toi", done.earliest_toi());
  check_fraction("advanced", done.advanced());
  check_fraction("way", done.way());
  if (done.has_advanced()) partial.advance.advanced = done.advanced();
  uint64_t came = 0;
  for_each_kind(
      [&](v1::ContactKind, const Contacts& host, const DeviceContacts& device) { came += host.count + device.count; },
      partial, partial.on_device);
  if (done.contact_count() != came)
    throw_lost("done.contact_count is " + std::to_string(done.contact_count()) + ", and " + std::to_string(came) +
               " contacts came");
  partial.done = std::move(done);
}

void FrameStream::State::complete(uint64_t frame_id) {
  FrameOutput output = std::exchange(partial, {});
  output.frame_id = frame_id;
  {
    const std::lock_guard lock(mutex);
    ready.push_back(std::move(output));
    in_flight.pop_front();
  }
  reading.notify();
}

void FrameStream::State::await_end(std::unique_lock<std::mutex>& lock) {
  while (!ended) {
    const size_t left = in_flight.size();
    const auto has_come = [&] { return ended || in_flight.size() < left; };
    if (await(lock, has_come, time_after(setup.deadline))) continue;
    transport->cancel();
    await(lock, [&] { return ended; });
    failure = Error(grpc::DEADLINE_EXCEEDED,
                    "the daemon at " + setup.address + " did not end the stream within " + text_of(setup.deadline));
  }
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
  await(lock, [&] { return ended || in_flight.size() < opened.window(); });
  if (ended) throw_ended();
}

void FrameStream::State::take_credit(const SentFrame& frame) {
  std::unique_lock lock(mutex);
  await_credit(lock);
  in_flight.push_back(frame);
}

void FrameStream::State::give_credit() {
  const std::lock_guard lock(mutex);
  if (!in_flight.empty()) in_flight.pop_back();
  reading.notify();
}

void FrameStream::State::send(const v1::Frame& frame, std::span<const FrameUpdate> updates) {
  if (setup.features) setup.features->check(frame, "frame");
  const bool has_mode = frame.advance() && frame.advance_mode() != v1::ADVANCE_MODE_UNSPECIFIED;
  take_credit({frame.frame_id(), has_mode ? frame.advance_mode() : v1::ADVANCE_MODE_ALL_OR_ONE, frame.limits()});
  if (frame.has_edit()) {
    const std::lock_guard lock(mutex);
    has_edits = true;
  }
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
