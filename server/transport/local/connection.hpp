#pragma once
// One local stream: its own thread reads the socket and admits frames; answers are sent by the scene's worker, or, if
// the client does not take them at once, by that thread.

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/frames/intake.hpp"
#include "server/frames/session.hpp"
#include "server/frames/stream_flow.hpp"
#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"
#include "server/refusals/status.hpp"
#include "server/transport/local/encode.hpp"
#include "server/transport/local/opening.hpp"
#include "server/transport/local/outbox.hpp"

namespace collided::server {

/// Time that a client has.
struct LocalTimeouts {
  double open_seconds = 10;  ///< to open its stream
  double take_seconds = 5;   ///< to take a waiting answer
};

class Connection final : public FrameSink, public std::enable_shared_from_this<Connection> {
 public:
  /// `rules` and `metrics` outlive it. Throws std::system_error, and then leaves the socket to the caller.
  Connection(Fd&& socket, const OpeningRules& rules, Metrics& metrics, LocalTimeouts timeouts);

  /// Gives the socket back, instead of serve().
  Fd release_socket() { return std::move(socket_); }
  /// Serves the stream to its end, on the calling thread.
  void serve();
  /// Ends the stream soon. Thread-safe.
  void stop();
  /// Ends the connection soon, unless its opening has come, read or not. False if it has, or if the connection has
  /// ended already. Thread-safe.
  bool end_unopened(const std::exception_ptr& why);
  /// Bytes of answers that the client has not taken.
  uint64_t outgoing_bytes() const;

  void opened(const Scene& scene) override;
  void answered(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame) override;
  void refused(uint64_t frame_id, const Failure& failure) override;
  void skipped(uint64_t frame_id) override;
  void draining(double seconds) override;
  void ended(const std::exception_ptr& why) override;

 private:
  using Clock = std::chrono::steady_clock;

  /// What the thread waits for.
  struct Wait {
    short events = 0;  ///< of the socket
    std::optional<Clock::time_point> until;
    Clock::time_point awake_until = Clock::time_point::min();  ///< without sleeping
  };

  bool poll_once();
  short wait(const Wait& wait) const;
  void check_timeouts();
  void take(Packet packet);
  void open(const pb::LocalOpen& open, std::vector<PassedFile> files);
  void submit(pb::LocalRequest& request);
  PendingFrame admit(Scene& scene, IncomingFrame incoming);
  void take_outcome(uint64_t frame_id);
  void flush_outbox();
  void end_socket();
  void wake() const;
  void send(std::vector<std::string> packets, bool ends_frame, const std::shared_ptr<const void>& held = {});
  void tell_end() const;

  // `_locked`: the caller holds mutex_.
  Wait next_wait_locked() const;
  bool may_read_locked() const;
  void flush_locked();
  void await_outbox_locked(Wait& wait) const;
  void end_frame_locked();
  void stay_awake_locked();
  void end_if_complete_locked();
  void close_locked(const Failure& why);

  const OpeningRules& rules_;
  Metrics& metrics_;
  const LocalTimeouts timeouts_;
  const Clock::time_point begin_ = Clock::now();
  Fd wake_;
  Fd socket_;                              // closed by the thread, with mutex_ held
  const CallIds ids_ = parse_ids({}, {});  // the protocol has none
  std::string requested_scene_id_;         // from the opening; owned by the thread
  Opening opening_;                        // set before the session
  std::optional<TurnAccount> account_;     // of its client's turns on the host; set by the opening
  std::unique_ptr<AnswerWriter> writer_;   // set before the session; then owned by the worker
  uint64_t submitted_ = 0;                 // frames, each of which is answered in its turn; owned by the thread

  mutable std::mutex mutex_;  // guards what follows
  std::shared_ptr<FrameSession> session_;
  Outbox outbox_;
  StreamFlow flow_;                // an answer has left once the outbox has it
  std::optional<Failure> closed_;  // why the stream ends, once decided
  Clock::time_point awake_until_ = Clock::time_point::min();
  bool is_opening_ = false;  // from the opening on
  bool is_stopping_ = false;
};

}  // namespace collided::server
