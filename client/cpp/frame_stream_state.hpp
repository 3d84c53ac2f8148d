#pragma once
// What a FrameStream holds: its credits, and the answers that are put together and wait to be received.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include "client/cpp/frame_stream.hpp"
#include "client/cpp/transport/frame_transport.hpp"
#include "client/cpp/transport/leader_followers.hpp"

namespace collided::client {

/// So long from now; at once for negative times. What overflows the clock is cut short.
FrameTransport::Time time_after(std::chrono::duration<double> time);

struct FrameStream::State {
  State(std::unique_ptr<FrameTransport> transport, const v1::OpenStream& open, StreamSetup setup);
  ~State();
  /// With the mutex: waits until `done`, or the deadline; whether it is done.
  template <class Done>
  bool await(std::unique_lock<std::mutex>& lock, const Done& done, FrameTransport::Time deadline);
  template <class Done>
  void await(std::unique_lock<std::mutex>& lock, const Done& done) {
    await(lock, done, FrameTransport::kNever);
  }
  /// With the mutex, in the lead. False if nothing came until the deadline.
  bool read_one(std::unique_lock<std::mutex>& lock, FrameTransport::Time deadline);
  /// The keeper's whole life: reads while nobody waits, so that answers move and pings are answered.
  void keep();
  /// Needs the mutex. `quiet`: pauses of the keeper in a row in which nobody waited.
  FrameTransport::Time keepers_deadline(int quiet) const;
  void take(v1::StreamFramesResponse& response);
  void complete(uint64_t frame_id);
  void send(const v1::Frame& frame, std::span<const FrameUpdate> updates);
  void take_credit();
  /// With the mutex. Throws Error once the stream has ended.
  void await_credit(std::unique_lock<std::mutex>& lock);
  void give_credit();
  /// Needs the mutex. Whether an output or the end is there to be received.
  bool has_news() const { return ended || !ready.empty(); }
  /// Needs the mutex, and news. Throws Error at the end.
  FrameOutput take_ready();
  /// Needs the mutex. Why the stream ended, as an Error.
  [[noreturn]] void throw_ended() const;

  const StreamSetup setup;
  std::unique_ptr<FrameTransport> transport;
  v1::StreamOpened opened;
  std::mutex mutex;
  Lead lead;                                ///< in reading
  uint64_t waits = 0;                       ///< of callers so far
  int waiting = 0;                          ///< callers that wait now
  std::map<uint64_t, FrameOutput> partial;  ///< the reading thread's alone
  std::deque<FrameOutput> ready;
  uint64_t in_flight = 0;
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
  const bool is_done = lead.await(lock, done, deadline, std::bind_front(&State::read_one, this));
  --waiting;
  return is_done;
}

}  // namespace collided::client
