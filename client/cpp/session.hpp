#pragma once
// A scene and its stream that survive the loss of the connection, and of the daemon.

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "client/cpp/client.hpp"

namespace collided::client {

/// How a session is opened, and how long it insists.
struct SessionOptions {
  ConnectOptions connect = {};
  /// Without a resume token, LATEST_WINS and handles of device memory, which a session refuses.
  StreamOptions stream = {};
  double lease_seconds = 0;  ///< of the scene, as of create_scene
  /// Time after a loss, 0 or more, in which a frame must be answered; then all frames in flight fail.
  std::chrono::milliseconds give_up = std::chrono::seconds(60);
  uint32_t max_attempts = 0;                      ///< to reconnect within that time; 0: any number
  std::chrono::milliseconds first_pause{50};      ///< between attempts, 0 or more; it doubles
  std::chrono::milliseconds longest_pause{2000};  ///< no less than first_pause
};

/// What became of a frame: its output, or the error that detect() would have thrown.
class FrameResult {
 public:
  /// Of a frame that was answered.
  FrameResult(uint64_t frame_id, FrameOutput output) : frame_id_(frame_id), output_(std::move(output)) {}
  /// Of one that failed.
  FrameResult(uint64_t frame_id, Error error) : frame_id_(frame_id), error_(std::move(error)) {}

  /// Counts the session's frames from 1, for those that failed, too.
  uint64_t frame_id() const { return frame_id_; }
  /// Whether the frame was answered.
  bool ok() const { return !error_; }
  /// Null if the frame was answered.
  const Error* error() const { return error_ ? &*error_ : nullptr; }
  /// Throws the error if there is one.
  FrameOutput& output() {
    if (error_) throw *error_;
    return output_;
  }

 private:
  uint64_t frame_id_;
  FrameOutput output_;
  std::optional<Error> error_;
};

/// Frames in, contacts out, over as many connections as it takes. After a loss the session connects again, resumes its
/// scene, or creates it anew if it is gone, puts it where the last answered frame left it, and sends the frames in
/// flight again, in order: each is answered once, with the contacts of an undisturbed run. So a session keeps copies of
/// the scene, its first frame, where its meshes are, and the frames in flight. Any thread may call any function; frames
/// are in the order of the calls. A loss is noticed, and the connection restored, only for a frame.
class Session {
 public:
  /// Connects, and creates a scene of `spec` (which must have no meshes) and `meshes`. `address` is host:port or
  /// unix:/path. Tries once. Throws Error as Client::connect, create_scene and stream do, and INVALID_ARGUMENT for
  /// options out of range.
  static Session open(const std::string& address, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
                      const SessionOptions& options = {});
  /// To where `client` leads, with its ConnectOptions; options.connect is not used. The client may be destroyed.
  static Session open(const Client& client, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
                      const SessionOptions& options = {});
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  /// Withdraws frames in flight. The scene lives until its lease ends. Waits for a call that is under way
  /// (ConnectOptions::patience, deadline) and for the function of a frame, unless that destroys it.
  ~Session();

  /// Sends a frame and waits for its output, whose frame_id counts the session's frames from 1. The first frame names
  /// every mesh. Throws Error if the frame is refused, which leaves the session open, and once the session gives up:
  /// then all frames in flight fail, and the next frame tries again from where the last answered one ended.
  FrameOutput detect(std::span<const FrameUpdate> updates, const FrameOptions& options = {});
  /// Copies a frame, sends it and returns: the future has what detect would return or throw. Waits while a whole window
  /// of frames is in flight. Throws Error: INVALID_ARGUMENT for options that a session could not repeat (`edit`,
  /// `from_last_fraction`, and `advance` in a scene with Q16 positions, which cannot name where that ends);
  /// FAILED_PRECONDITION once the session is closed.
  std::future<FrameOutput> submit(std::span<const FrameUpdate> updates, const FrameOptions& options = {});
  /// The same with a function that is called once, instead of a future. The session's own thread calls it, one frame at
  /// a time, in the order of the frames; only a frame that is too large to be sent fails at once, on the thread that
  /// sends it. Answers that come meanwhile wait, so it should be quick. It may submit frames, which then never wait for
  /// a place in the window, and close or destroy the session, whose other frames fail after it has returned. It must
  /// not call detect(), or wait for a future of the same session: detect() throws Error (FAILED_PRECONDITION) there. It
  /// must not throw: that ends the program (std::terminate). What this throws itself is as above, and then the
  /// function is not called.
  void submit(std::span<const FrameUpdate> updates, std::function<void(FrameResult)> done,
              const FrameOptions& options = {});
  /// Ends the session and deletes its scene. Frames in flight fail with CANCELLED. Throws Error if the scene could not
  /// be deleted; then its lease ends it.
  void close();

  /// The scene as it was created last.
  v1::Scene scene() const;
  /// How many frames may be in flight.
  uint32_t window() const;
  /// How often a stream was opened again.
  uint64_t reconnects() const;
  /// How often the scene was created again.
  uint64_t recreations() const;

 private:
  struct State;
  explicit Session(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;  // its thread has it, too
};

}  // namespace collided::client
