#pragma once
// One local stream: a thread of its own reads the socket and takes frames in; answers go out from the scene's worker,
// or, where the client does not take them at once, from that thread.

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/local/answer.hpp"
#include "server/local/opening.hpp"
#include "server/local/outbox.hpp"
#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"
#include "server/scenes/frame_session.hpp"
#include "server/service/status.hpp"

namespace collided::server {

/// How long a client may take.
struct LocalPatience {
  double open_seconds = 10;  ///< until it opens its stream
  double take_seconds = 5;   ///< while answers wait and it takes none
};

class Connection final : public FrameSink, public std::enable_shared_from_this<Connection> {
 public:
  /// `rules` and `metrics` outlive it. Throws std::system_error.
  Connection(Fd socket, const OpeningRules& rules, Metrics& metrics, LocalPatience patience);

  /// Serves the stream to its end, on the calling thread.
  void serve();
  /// Ends the stream soon. From any thread.
  void stop();
  /// Bytes of answers that the client has not taken yet.
  uint64_t outgoing_bytes() const;

  void opened(const Scene& scene) override;
  void answered(const Scene& scene, AnsweredFrame frame) override;
  void refused(uint64_t frame_id, const std::exception_ptr& error) override;
  void skipped(uint64_t frame_id) override;
  void draining(double seconds) override;
  void ended(const std::exception_ptr& why) override;

 private:
  using Clock = std::chrono::steady_clock;

  /// What the thread waits for.
  struct Wait {
    short events = 0;  ///< of the socket
    std::optional<Clock::time_point> until;
  };

  bool turn();
  short wait(const Wait& wait) const;
  void check_patience();
  void take(Packet packet);
  void open(const pb::LocalOpen& open, std::vector<PassedFile> files);
  void submit(pb::LocalRequest& request);
  void send_rest();
  void end_socket();
  void wake() const;
  void send(std::vector<std::string> packets, bool ends_frame, const std::shared_ptr<const void>& held = {});
  void log_end() const;

  // `_locked`: the caller holds mutex_.
  Wait next_wait_locked() const;
  bool may_read_locked() const;
  void flush_locked();
  void end_frame_locked();
  void end_if_idle_locked();
  void close_locked(const Failure& why);

  const OpeningRules& rules_;
  Metrics& metrics_;
  const LocalPatience patience_;
  const Clock::time_point begin_ = Clock::now();
  Fd socket_;  // closed by the thread, with mutex_ held
  Fd wake_;
  const CallIds ids_ = parse_ids({}, {});  // the protocol brings none
  std::string asked_scene_;                // by the opening; of this thread alone
  Opening opening_;                        // set before the session
  std::unique_ptr<AnswerWriter> writer_;   // the same; then the worker's

  mutable std::mutex mutex_;  // guards what follows
  std::shared_ptr<FrameSession> session_;
  Outbox outbox_;
  uint32_t in_flight_ = 0;         // frames that are not answered yet
  std::optional<Failure> closed_;  // why the stream ends, once that is decided
  bool read_all_ = false, is_stopping_ = false;
};

}  // namespace collided::server
