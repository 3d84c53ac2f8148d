#pragma once
// Many streams on two threads: one sends frames when they are due, the other takes answers, and sends what is overdue
// as soon as the window has room.

#include <condition_variable>
#include <mutex>
#include <queue>
#include <thread>
#include <vector>

#include "client/measure/load/drive/frame_call.hpp"
#include "client/measure/load/drive/messages.hpp"
#include "client/measure/load/drive/stream_pace.hpp"
#include "client/measure/load/tally/stream_states.hpp"

namespace collided::cli::load {

class Lane {
 public:
  static constexpr size_t kThreads = 2;

  /// `messages` must outlive it.
  explicit Lane(const Messages& messages);
  Lane(const Lane&) = delete;
  Lane& operator=(const Lane&) = delete;
  /// Cancels streams that are still open.
  ~Lane();

  /// Begins to open a stream; states() tells how that goes.
  void open(std::shared_ptr<grpc::Channel> channel, std::unique_ptr<grpc::ClientContext> context,
            const v1::OpenStream& open, StreamPlace place);
  StreamStates states() const;

  void begin(const Phase& phase);
  /// A closed loop sends nothing more.
  void stop();
  /// Whether every stream that is still open has sent all of its frames, and has all answers.
  bool is_idle() const;
  void give_up(Time now);
  /// What was counted since the last call.
  Tally take_tally();
  Second take_second();
  /// Tells the daemon that no more frames will come; states() tells when all streams have ended.
  void finish();
  /// CPU time of its two threads; the larger.
  double busiest_thread_seconds();

 private:
  enum class State { kOpening, kOpen, kEnded };
  struct Stream {
    std::unique_ptr<FrameCall> call;
    v1::OpenStream open;
    StreamPlace place;
    StreamPace pace;
    State state = State::kOpening;
    bool is_queued = false, is_ending = false;
  };
  struct Due {
    Time time;
    Stream* stream;
    bool operator<(const Due& other) const { return time > other.time; }  // the earliest is on top
  };

  void run_sender();
  void run_receiver();
  /// All of these need the mutex.
  void take(Stream& stream, const v1::StreamFramesResponse& message, Time now);
  void handle(Stream& stream, FrameCall::Event event, bool is_ok, Time now);
  void end(Stream& stream);
  void advance(Stream& stream);
  Books books() { return {tally_, second_}; }

  const Messages& messages_;
  grpc::CompletionQueue queue_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::priority_queue<Due> due_;
  StreamStates states_;
  Tally tally_;
  Second second_;
  bool is_finishing_ = false, is_closing_ = false;
  std::thread sender_, receiver_;
};

}  // namespace collided::cli::load
