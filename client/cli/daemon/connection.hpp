#pragma once
// A client of the daemon that the options name, or of one started for it.

#include <chrono>
#include <optional>
#include <span>

#include "client/cli/daemon/interrupt.hpp"
#include "client/cli/daemon/own_daemon.hpp"
#include "client/cli/options/options.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

/// A scene that is deleted at the end of its scope, also when an error ends it.
class SceneGuard {
 public:
  /// `goes_with_daemon`: an interrupted collidectl need not wait until it is deleted.
  SceneGuard(client::Client& client, v1::Scene scene, bool goes_with_daemon = false)
      : client_(client), scene_(std::move(scene)), goes_with_daemon_(goes_with_daemon) {}
  SceneGuard(const SceneGuard&) = delete;
  SceneGuard& operator=(const SceneGuard&) = delete;
  ~SceneGuard() {
    if (goes_with_daemon_ && is_interrupted()) return;
    try {
      client_.delete_scene(scene_.scene_id());
    } catch (const client::Error&) {  // the daemon is gone, and the scene with it
    }
  }
  const v1::Scene& operator*() const { return scene_; }
  const v1::Scene* operator->() const { return &scene_; }

 private:
  client::Client& client_;
  v1::Scene scene_;
  bool goes_with_daemon_;
};

/// Reads the token's file. Throws std::runtime_error naming it.
client::ConnectOptions connect_options(const ServerOptions& options);

/// Whom memory is shared with. Throws UsageError for a user that this host does not know.
client::LocalOptions local_options(const ServerOptions& options);

class Connection {
 public:
  explicit Connection(const ServerOptions& options) : local_(local_options(options)), client_(open(options)) {}
  client::Client& operator*() { return client_; }
  client::Client* operator->() { return &client_; }

  /// Interrupts are noted once there is a scene; if the daemon is one of others, even before.
  SceneGuard create_scene(const v1::SceneSpec& spec, std::span<const client::MeshInput> meshes) {
    if (!daemon_) note_interrupts();
    v1::Scene scene = client_.create_scene(spec, meshes);
    note_interrupts();
    return SceneGuard(client_, std::move(scene), daemon_.has_value());
  }
  /// `window`: as client::StreamOptions has it.
  client::FrameStream stream(const v1::Scene& scene, uint32_t window = 0) {
    return client_.stream(scene, {.window = window, .local = local_});
  }

 private:
  client::Client open(const ServerOptions& options);

  const client::LocalOptions local_;
  std::optional<OwnDaemon> daemon_;  // made before the client and stopped after it
  client::Client client_;
};

/// The next answer. Throws Interrupted.
inline client::FrameOutput receive(client::FrameStream& stream) {
  constexpr std::chrono::milliseconds kPatience(50);
  for (;;) {
    check_interrupt();
    if (auto output = stream.receive_within(kPatience)) return std::move(*output);
  }
}

/// One frame, with none other in flight. Throws its refusal, and Interrupted.
inline client::FrameOutput run_frame(client::FrameStream& stream, const v1::Frame& frame) {
  check_interrupt();
  stream.send(frame);
  client::FrameOutput output = receive(stream);
  output.check();
  return output;
}

}  // namespace collided::cli
