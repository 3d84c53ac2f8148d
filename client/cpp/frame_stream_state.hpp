#pragma once
// Inside a FrameStream: its credits, and answers that are being assembled or wait to be received.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

#include "client/cpp/frame_stream.hpp"
#include "client/cpp/transport/frame_transport.hpp"
#include "client/cpp/transport/leader_followers.hpp"

namespace collided::client {

/// `time` from now: now for negative times, about 30 years for longer ones, which would overflow the clock.
FrameTransport::Time time_after(std::chrono::duration<double> time);

/// Keeps what a frame's answer is checked against.
struct SentFrame {
  uint64_t id;
  v1::AdvanceMode advance_mode;  ///< ALL_OR_ONE also without `advance`
  bool limits;                   ///< it asks for them
};

struct FrameStream::State {
  State(std::unique_ptr<FrameTransport> transport, const v1::OpenStream& open, StreamSetup setup);
  ~State();
  /// Needs the mutex. Waits until `done` or the deadline; returns whether it is done.
  template <class Done>
  bool await(std::unique_lock<std::mutex>& lock, const Done& done, FrameTransport::Time deadline);
  template <class Done>
  void await(std::unique_lock<std::mutex>& lock, const Done& done) {
    await(lock, done, FrameTransport::kNever);
  }
  /// Needs the mutex, and to lead. False if nothing came by the deadline.
  bool read_one(std::unique_lock<std::mutex>& lock, FrameTransport::Time deadline);
  /// The keeper's thread.
  void run_keeper();
  /// Needs the mutex. `quiet_pauses`: of the keeper, in a row, in which no caller waited.
  FrameTransport::Time keeper_deadline(int quiet_pauses) const;
  void take(v1::StreamFramesResponse& response);
  /// Returns the oldest frame in flight. Throws Error (DATA_LOSS) unless it has that id.
  SentFrame next_answered(uint64_t frame_id);
  void add(const v1::ContactChunk& chunk);
  void add_limits(const v1::ContactChunk& chunk);
  /// Checks the contacts of a chunk, from the `first` on, against what the scene has.
  void check(v1::ContactKind kind, const Contacts& contacts, uint64_t first);
  void add(const v1::ShortenedWays& ways);
  void add(const v1::MeshPairs& pairs);
  void finish_frame(v1::FrameDone& done);
  void complete(uint64_t frame_id);
  void send(const v1::Frame& frame, std::span<const FrameUpdate> updates);
  void take_credit(const SentFrame& frame);
  /// Needs the mutex. Throws Error once the stream has ended.
  void await_credit(std::unique_lock<std::mutex>& lock);
  void give_credit();
  /// Needs the mutex. Throws Error (DEADLINE_EXCEEDED), and ends the stream, if nothing comes in time.
  void await_end(std::unique_lock<std::mutex>& lock);
  /// Needs the mutex. Whether there is an output, or the end, to receive.
  bool has_news() const { return ended || !ready.empty(); }
  /// Needs the mutex and has_news(). Throws Error at the end.
  FrameOutput take_ready();
  /// Needs the mutex. Why the stream ended, as an Error.
  [[noreturn]] void throw_ended() const;

  const StreamSetup setup;
  const bool may_skip;  ///< LATEST_WINS
  std::unique_ptr<FrameTransport> transport;
  v1::StreamOpened opened;
  std::mutex mutex;
  LeaderFollowers reading;    ///< one waiting caller reads for all
  uint64_t waits = 0;         ///< how often callers have waited
  int waiting = 0;            ///< callers that wait now
  FrameOutput partial;        ///< of the oldest frame in flight; used by the reading thread only
  bool takes_limits = false;  ///< that frame asks for them; likewise
  std::deque<FrameOutput> ready;
  std::deque<SentFrame> in_flight;  ///< the oldest first
  SceneSize size;                   ///< as of the opening; 0 if the daemon does not tell it
  bool has_edits = false;           ///< the scene may have another size by now
  bool ended = false;
  bool half_closed = false;
  std::optional<Error> failure;  ///< why it ended
  std::optional<std::chrono::steady_clock::time_point> draining;
  bool is_stopping = false;
  std::condition_variable stop;
  std::thread keeper;
};

template <class Done>
bool FrameStream::State::await(std::unique_lock<std::mutex>& lock, const Done& done, FrameTransport::Time deadline) {
  if (done()) return true;
  ++waits;
  ++waiting;
  const bool is_done = reading.await(lock, done, deadline, std::bind_front(&State::read_one, this));
  --waiting;
  return is_done;
}

}  // namespace collided::client
