#pragma once
// A client of the daemon that the options name, or of one started for it.

#include <optional>
#include <span>

#include "client/cli/interrupt.hpp"
#include "client/cli/options.hpp"
#include "client/cli/own_daemon.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

/// A scene that is deleted at the end of its scope, also when an error ends it.
class SceneGuard {
 public:
  SceneGuard(client::Client& client, v1::Scene scene) : client_(client), scene_(std::move(scene)) {}
  SceneGuard(const SceneGuard&) = delete;
  SceneGuard& operator=(const SceneGuard&) = delete;
  ~SceneGuard() {
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
};

/// Reads the token's file. Throws std::runtime_error naming it.
client::ConnectOptions connect_options(const ServerOptions& options);

class Connection {
 public:
  explicit Connection(const ServerOptions& options) : client_(open(options)) {}
  client::Client& operator*() { return client_; }
  client::Client* operator->() { return &client_; }

  /// Interrupts are noted from here on if the daemon is one of others: the scene has to be deleted then, too.
  SceneGuard create_scene(const v1::SceneSpec& spec, std::span<const client::MeshInput> meshes) {
    if (!daemon_) note_interrupts();
    return SceneGuard(client_, client_.create_scene(spec, meshes));
  }

 private:
  client::Client open(const ServerOptions& options);

  std::optional<OwnDaemon> daemon_;  // made before the client and stopped after it
  client::Client client_;
};

/// One frame, with none other in flight. Throws its refusal, and Interrupted.
inline client::FrameOutput run_frame(client::FrameStream& stream, const v1::Frame& frame) {
  check_interrupt();
  stream.send(frame);
  client::FrameOutput output = stream.receive();
  check_interrupt();
  output.check();
  return output;
}

}  // namespace collided::cli
