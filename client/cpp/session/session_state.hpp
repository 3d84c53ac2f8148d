#pragma once
// Inside a Session: its frames in flight, the thread that receives their answers, and what happens after a loss.

#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "client/cpp/session.hpp"
#include "client/cpp/session/connector.hpp"

namespace collided::client {

using Done = std::function<void(FrameResult)>;

/// A frame without an answer.
struct FrameInFlight {
  uint64_t number;   ///< of the session
  uint64_t wire_id;  ///< of the stream; 0: not sent on this one
  OwnedFrame frame;
  Done done;
};

/// Since a loss, until a frame is answered.
struct Trouble {
  std::chrono::steady_clock::time_point deadline;
  std::chrono::milliseconds pause;
  uint32_t attempts;
};

struct Session::State : std::enable_shared_from_this<Session::State> {
  using Lock = std::unique_lock<std::mutex>;

  /// Connects, and starts the receiver, which keeps the state until it ends.
  static std::shared_ptr<State> begin(ChannelFactory channels, const v1::SceneSpec& spec,
                                      std::span<const MeshInput> meshes, const SessionOptions& options);
  State(ChannelFactory channels, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
        const SessionOptions& options);
  void submit(OwnedFrame frame, Done done);
  /// Frames in flight fail, and the receiver ends: before this returns, unless it is the receiver that calls. False if
  /// this has happened before.
  bool stop();
  /// The same for good: nobody but the receiver uses the state afterwards.
  void end();
  /// Whether the receiver calls: a function of a frame does.
  bool is_own_thread() const { return receiver_id == std::this_thread::get_id(); }

  /// The receiver's thread.
  void run();
  void receive_one(Lock& lock);
  void reopen(Lock& lock);
  /// From a daemon that stops to another one, with nothing in flight. Where there is none, frames are answered until
  /// the daemon closes the stream, and this is tried again.
  void leave(Lock& lock);
  void lose(Lock& lock, const Error& error);
  void wait_for_next_attempt(Lock& lock, const Error& error);
  void fail_all(Lock& lock, const Error& error);
  /// Needs is_ready, and that nobody is sending: then nobody else does.
  void send_unsent(Lock& lock);

  const Connector connector;
  SceneMemory memory;  ///< used by the receiver only
  std::mutex mutex;
  std::condition_variable changed;
  v1::Scene scene;
  std::optional<FrameStream> stream;  ///< opened and dropped by the receiver only
  uint32_t window = 0;
  bool is_ready = true;     ///< the stream's scene is where `memory` is
  bool is_leaving = false;  ///< no frame is sent until those in flight are answered
  std::chrono::steady_clock::time_point next_leave{};
  bool is_closed = false;
  std::list<FrameInFlight> frames;
  uint64_t sending = 0;  ///< wire_id of the frame that a thread is sending
  uint64_t last_wire_id = 0, last_number = 0;
  std::optional<Trouble> trouble;
  uint64_t reconnects = 0, recreations = 0;
  std::thread receiver;
  std::thread::id receiver_id;  ///< set before anyone else has the state
};

}  // namespace collided::client
