// One local stream.
#include "server/transport/local/connection.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <thread>
#include <utility>

#include "proto/constants.hpp"
#include "server/errors.hpp"
#include "server/frames/log.hpp"
#include "server/frames/messages.hpp"
#include "server/shorten.hpp"
#include "server/transport/local/shared_frame.hpp"

namespace collided::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr StreamKind kKind{"local stream", "LocalStream"};
constexpr auto kGone = "the client is gone";
constexpr double kLastPacketSeconds = 0.2;                // to send the remaining packets when the daemon stops
constexpr auto kShortage = std::chrono::milliseconds(5);  // until a packet for which there was no memory is sent again
constexpr auto kAwake = std::chrono::microseconds(300);   // for the next frame of a simulator on the same GPU

Clock::time_point after(Clock::time_point start, double seconds) {
  return start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// Rounded up, so that the deadline has passed when poll() returns.
int milliseconds_until(const std::optional<Clock::time_point>& time) {
  if (!time) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(*time - Clock::now()).count();
  return static_cast<int>(std::clamp<int64_t>(left, 0, 3'600'000));
}

// Who connected.
Origin origin_of_process(int socket) {
  ucred process{};
  socklen_t size = sizeof(process);
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &process, &size) != 0) return {};
  return {fmt::format("uid:{}", process.uid), fmt::format("pid:{}", process.pid)};
}

bool has_packet(int socket) {
  char first = 0;
  return recv(socket, &first, 1, MSG_PEEK | MSG_DONTWAIT) > 0;
}

Fd make_event() {
  Fd event(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!event) throw std::system_error(errno, std::generic_category(), "eventfd");
  return event;
}

}  // namespace

Connection::Connection(Fd&& socket, const OpeningRules& rules, Metrics& metrics, LocalTimeouts timeouts)
    : rules_(rules), metrics_(metrics), timeouts_(timeouts), wake_(make_event()) {
  socket_ = std::move(socket);  // when nothing can fail any more
}

void Connection::serve() {
  try {
    PacketReceiver receiver(socket_.get());
    while (poll_once()) {
      const bool may_read = [this] {
        const std::lock_guard lock(mutex_);
        return may_read_locked();
      }();
      if (may_read) take(receiver.receive());
    }
  } catch (...) {
    ended(std::current_exception());
  }
  if (session_) session_->close();
  flush_outbox();
  tell_end();
  end_socket();
}

// Waits for an event and handles it. False at the end of the stream.
bool Connection::poll_once() {
  Wait next;
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return false;
    next = next_wait_locked();
  }
  const short events = wait(next);
  if (events & (POLLHUP | POLLERR)) {
    const std::lock_guard lock(mutex_);
    outbox_.drop();
    close_locked({grpc::StatusCode::CANCELLED, kGone});
  }
  {
    const std::lock_guard lock(mutex_);
    if (events & POLLOUT || outbox_.is_short()) flush_locked();
  }
  check_timeouts();
  return true;
}

Connection::Wait Connection::next_wait_locked() const {
  Wait wait;
  wait.awake_until = awake_until_;
  if (may_read_locked()) wait.events |= POLLIN;
  if (!session_) wait.until = after(begin_, timeouts_.open_seconds);
  if (outbox_.empty()) return wait;
  const auto until = after(outbox_.stalled_since(), timeouts_.take_seconds);
  wait.until = wait.until ? std::min(*wait.until, until) : until;
  await_outbox_locked(wait);
  return wait;
}

// A socket that has room is ready at once, however short of memory the system is.
void Connection::await_outbox_locked(Wait& wait) const {
  if (outbox_.is_short())
    wait.until = std::min(*wait.until, Clock::now() + kShortage);
  else
    wait.events |= POLLOUT;
}

bool Connection::may_read_locked() const { return flow_.may_read(); }

short Connection::wait(const Wait& wait) const {
  pollfd states[] = {{socket_.get(), wait.events, 0}, {wake_.get(), POLLIN, 0}};
  int ready = 0;
  while (ready == 0 && Clock::now() < wait.awake_until)
    if ((ready = poll(states, 2, 0)) == 0) std::this_thread::yield();
  if (ready == 0) ready = poll(states, 2, milliseconds_until(wait.until));
  if (ready < 0) return 0;
  if (states[1].revents & POLLIN) {
    eventfd_t count = 0;
    eventfd_read(wake_.get(), &count);
  }
  return states[0].revents;
}

void Connection::check_timeouts() {
  const std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  if (!session_ && now >= after(begin_, timeouts_.open_seconds))
    close_locked({grpc::StatusCode::DEADLINE_EXCEEDED,
                  fmt::format("the client did not open its stream within {} s", timeouts_.open_seconds)});
  if (!outbox_.empty() && now >= after(outbox_.stalled_since(), timeouts_.take_seconds))
    close_locked({grpc::StatusCode::DEADLINE_EXCEEDED,
                  fmt::format("the client took none of its answers for {} s", timeouts_.take_seconds)});
}

void Connection::take(Packet packet) {
  if (packet.arrival == Arrival::kNothing) return;
  if (packet.arrival == Arrival::kGone) {
    const std::lock_guard lock(mutex_);
    return close_locked({grpc::StatusCode::CANCELLED, kGone});
  }
  if (packet.arrival == Arrival::kEnd) {
    const std::lock_guard lock(mutex_);
    flow_.half_close();
    return end_if_complete_locked();
  }
  pb::LocalRequest request;
  if (!request.ParseFromArray(packet.bytes.data(), static_cast<int>(packet.bytes.size())))
    throw InvalidInput("packet", "packet is cut off or malformed: its bytes are not a LocalRequest");
  if (!session_) {
    if (!request.has_open()) throw FailedPrecondition("open", "the first packet of a stream must be `open`");
    return open(request.open(), std::move(packet.files));
  }
  if (!packet.files.empty()) throw InvalidInput("packet", "packet has a file, which only the first one may have");
  session_->scene().worker().wake_early();
  submit(request);
}

void Connection::open(const pb::LocalOpen& open, std::vector<PassedFile> files) {
  {
    const std::lock_guard lock(mutex_);
    is_opening_ = true;
  }
  requested_scene_id_ = shorten(open.open().scene_id(), 64);
  opening_ = check_opening(open, std::move(files), rules_, origin_of_process(socket_.get()));
  account_.emplace(rules_.host.host_turns().account(opening_.client->turn_path()));
  writer_ = std::make_unique<AnswerWriter>(opening_.region, opening_.terms.window);
  {
    const std::lock_guard lock(mutex_);
    flow_.open(opening_.terms.window);
  }
  auto session =
      FrameSession::open(opening_.scene, open.open().resume_token(), opening_.terms.delivery, shared_from_this(), ids_);
  {
    const std::lock_guard lock(mutex_);
    session_ = session;
    if (!outbox_.empty()) session->hold(true);
  }
  opening_.scene->engine().charge_to(opening_.client->turn_path());
  rules_.host.tell_of_stop(*session);
  log_stream_opened(kKind, *opening_.scene, opening_.terms.window, ids_);
}

void Connection::submit(pb::LocalRequest& request) {
  Scene& scene = session_->scene();
  const SharedRegion* const region = opening_.region.get();
  IncomingFrame incoming;
  MemoryHold copied(scene.quota());
  if (request.has_shared_frame())
    incoming.message = read_frame(region, request.shared_frame(), *scene.plan(), copied);
  else if (request.has_frame())
    incoming.message = std::move(*request.mutable_frame());
  else
    throw FailedPrecondition("frame", "packets after the first must be `frame` or `shared_frame`");
  place_ranges(region, incoming);
  incoming.memory = opening_.region;
  incoming.answer_bytes_per_contact = scene.plan()->fields.contact_bytes();
  if (region && region->has_device_output()) incoming.room = region->output_part(submitted_, opening_.terms.window);
  ++submitted_;
  PendingFrame frame = admit(scene, std::move(incoming));
  {
    const std::lock_guard lock(mutex_);
    flow_.submit(frame.frame_id, frame.input.edit != nullptr);
  }
  session_->submit(std::move(frame));
}

// The connection's own thread waits for the turn, and nothing else of it goes on meanwhile.
PendingFrame Connection::admit(Scene& scene, IncomingFrame incoming) {
  size_t bytes = 0;
  for (const PlacedPositions& placed : incoming.placed)
    bytes += placed.start.size() + placed.end.size() + placed.indices.size();
  std::optional<Turns::Turn> turn;
  if (bytes > kMaxUnsharedBytes)
    turn.emplace(rules_.host.host_turns().take(*account_, [this] {
      const std::lock_guard lock(mutex_);
      return closed_.has_value();
    }));
  return admit_frame(rules_.host, scene, std::move(incoming));
}

void Connection::opened(const Scene& scene) {
  send({opened_packet(scene, opening_.terms.window)}, false);
  const std::lock_guard lock(mutex_);
  flow_.opened();
  end_if_complete_locked();
}

void Connection::answered(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame) {
  take_outcome(frame->frame_id);
  send(writer_->write(scene, *frame), true, frame->result.held);
}

void Connection::refused(uint64_t frame_id, const Failure& failure) {
  take_outcome(frame_id);
  writer_->skip();
  send({to_packet(refusal_message(frame_id, failure))}, true);
}

// The thread does not read the socket while an edit is pending.
void Connection::take_outcome(uint64_t frame_id) {
  const std::lock_guard lock(mutex_);
  if (flow_.answer(frame_id)) wake();
}

void Connection::skipped(uint64_t frame_id) {
  writer_->skip();
  send({to_packet(skipped_message(frame_id))}, true);
}

void Connection::draining(double seconds) { send({to_packet(draining_message(seconds))}, false); }

void Connection::ended(const std::exception_ptr& why) {
  const std::lock_guard lock(mutex_);
  close_locked(describe(why));
}

void Connection::stop() {
  const std::lock_guard lock(mutex_);
  is_stopping_ = true;
  close_locked(describe(std::make_exception_ptr(Stopping())));
  wake();
}

bool Connection::end_unopened(const std::exception_ptr& why) {
  const std::lock_guard lock(mutex_);
  if (is_opening_ || closed_ || has_packet(socket_.get())) return false;
  close_locked(describe(why));
  return true;
}

uint64_t Connection::outgoing_bytes() const {
  const std::lock_guard lock(mutex_);
  return outbox_.bytes();
}

void Connection::send(std::vector<std::string> packets, bool ends_frame, const std::shared_ptr<const void>& held) {
  const std::lock_guard lock(mutex_);
  if (closed_) return;
  const bool was_empty = outbox_.empty();
  for (auto& packet : packets) outbox_.send(socket_.get(), std::move(packet), held);
  if (outbox_.is_gone()) return close_locked({grpc::StatusCode::CANCELLED, kGone});
  if (ends_frame) end_frame_locked();
  if (!was_empty || outbox_.empty()) return;
  if (session_) session_->hold(true);
  wake();
}

// The thread does not read the socket while the window is used up.
void Connection::end_frame_locked() {
  if (flow_.release()) wake();
  if (opening_.region && opening_.region->has_device_output()) stay_awake_locked();
  end_if_complete_locked();
}

// A simulator on the same GPU has nothing to copy: to wake two threads for its next frame would take longer than the
// rest.
void Connection::stay_awake_locked() {
  awake_until_ = Clock::now() + kAwake;
  session_->scene().worker().wake_early();
  wake();
}

void Connection::flush_locked() {
  outbox_.flush(socket_.get());
  if (outbox_.is_gone()) close_locked({grpc::StatusCode::CANCELLED, kGone});
  if (session_) session_->hold(!outbox_.empty());
}

void Connection::end_if_complete_locked() {
  if (flow_.is_complete()) close_locked({});
}

void Connection::close_locked(const Failure& why) {
  if (closed_) return;
  closed_ = why;
  flow_.end();
  outbox_.send(socket_.get(), closed_packet(why));
  wake();
}

// Until the client has taken everything, is gone, or its time is up.
void Connection::flush_outbox() {
  const auto begin = Clock::now();
  for (;;) {
    Wait wanted;
    {
      const std::lock_guard lock(mutex_);
      flush_locked();
      wanted.until = after(is_stopping_ ? begin : outbox_.stalled_since(),
                           is_stopping_ ? kLastPacketSeconds : timeouts_.take_seconds);
      if (outbox_.empty() || Clock::now() >= *wanted.until) return;
      await_outbox_locked(wanted);
    }
    if (wait(wanted) & (POLLHUP | POLLERR)) return;
  }
}

// Under the lock, as the worker may be about to send.
void Connection::end_socket() {
  const std::lock_guard lock(mutex_);
  outbox_.drop();
  end_connection(std::exchange(socket_, Fd()));
  opening_.ticket.reset();
}

void Connection::wake() const { eventfd_write(wake_.get(), 1); }

void Connection::tell_end() const {
  const std::lock_guard lock(mutex_);
  if (!closed_) return;
  tell_stream_ended(kKind,
                    {.level = session_ || closed_->code ? spdlog::level::info : spdlog::level::debug,
                     .scene = requested_scene_id_,
                     .code = closed_->code,
                     .reason = closed_->message},
                    ids_, metrics_);
}

}  // namespace collided::server
