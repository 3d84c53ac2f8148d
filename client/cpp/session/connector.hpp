#pragma once
// Connects a session to its scene, as often as it takes.

#include <chrono>
#include <optional>

#include "client/cpp/session.hpp"
#include "client/cpp/session/owned_frame.hpp"
#include "client/cpp/session/scene_memory.hpp"
#include "client/cpp/transport/grpc/channel.hpp"

namespace collided::client {

/// Whether a loss, or what keeps a session from its scene, may pass.
bool may_pass(const Error& error);

class Connector {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Opened {
    v1::Scene scene;
    FrameStream stream;
    bool is_new;
  };

  /// Throws Error (INVALID_ARGUMENT) for what a session cannot have.
  Connector(ChannelFactory channels, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
            const SessionOptions& options);

  const SessionOptions& options() const { return options_; }
  const OwnedScene& input() const { return input_; }
  /// Creates the scene, and opens its stream.
  Opened create() const;
  /// Resumes the scene, or creates it if it is gone. Its calls end by the deadline. What a frame without an answer has
  /// fixed of a scene without others nobody can tell: it is not reusable, and deleted.
  Opened reopen(const v1::Scene& scene, bool is_reusable, Time deadline) const;
  /// Creates the scene on another daemon than the one that stops; none if no daemon takes it, and the scene stays.
  std::optional<Opened> leave(const v1::Scene& scene) const;
  /// Waits for an answer, however long that takes. Throws Error once the stream has ended, and if the daemon is silent:
  /// over gRPC keepalive ends the stream then, which a local socket does not have.
  FrameOutput receive(FrameStream& stream) const;
  /// Puts a scene where `memory` has it. Returns the last frame's id.
  uint64_t restore(FrameStream& stream, const SceneMemory& memory) const;
  /// Ignores that it is gone.
  void remove(const v1::Scene& scene) const;

 private:
  Opened create(Client& client) const;
  /// The options of a connection whose calls end within this time.
  ConnectOptions options_within(std::chrono::milliseconds time) const;
  void check_answers() const;
  void ask(FrameStream& stream, uint64_t id, std::span<const FrameUpdate> updates, const FrameOptions& options) const;

  const ChannelFactory channels_;
  const SessionOptions options_;
  const OwnedScene input_;
};

}  // namespace collided::client
