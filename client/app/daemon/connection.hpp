#pragma once
// A client of the daemon that the options name, or of one started for this command.

#include <chrono>
#include <optional>
#include <span>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/daemon/own_daemon.hpp"
#include "client/app/options/values.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

/// Deletes a scene at the end of its scope.
class SceneGuard {
 public:
  /// `dies_with_daemon`: an interrupted collidectl need not delete it.
  SceneGuard(client::Client& client, v1::Scene scene, bool dies_with_daemon = false)
      : client_(client), scene_(std::move(scene)), dies_with_daemon_(dies_with_daemon) {}
  SceneGuard(const SceneGuard&) = delete;
  SceneGuard& operator=(const SceneGuard&) = delete;
  ~SceneGuard() {
    if (dies_with_daemon_ && is_interrupted()) return;
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
  bool dies_with_daemon_;
};

/// Reads the token file. Throws std::runtime_error naming it.
client::ConnectOptions connect_options(const ServerOptions& options);

/// Throws UsageError for a daemon user unknown on this host.
client::LocalOptions local_options(const ServerOptions& options);

class Connection {
 public:
  explicit Connection(const ServerOptions& options) : local_(local_options(options)), client_(open(options)) {}
  client::Client& operator*() { return client_; }
  client::Client* operator->() { return &client_; }

  /// Asks for every field of contacts that the daemon knows.
  void ask_for_all_fields(v1::SceneSpec& spec) const {
    for (const v1::ContactField field : client_.contact_fields()) spec.add_fields(field);
  }
  /// Defers interrupts: on a foreign daemon before it creates the scene, which must be deleted; else once it exists.
  SceneGuard create_scene(const v1::SceneSpec& spec, std::span<const client::MeshInput> meshes) {
    if (!daemon_) defer_interrupts();
    v1::Scene scene = client_.create_scene(spec, meshes);
    defer_interrupts();
    return SceneGuard(client_, std::move(scene), daemon_.has_value());
  }
  /// `window` as in client::StreamOptions.
  client::FrameStream stream(const v1::Scene& scene, uint32_t window = 0) {
    return client_.stream(scene, {.window = window, .local = local_});
  }

 private:
  client::Client open(const ServerOptions& options);

  const client::LocalOptions local_;
  std::optional<OwnDaemon> daemon_;  // made before the client and stopped after it
  client::Client client_;
};

/// The next output. Throws Interrupted.
inline client::FrameOutput receive(client::FrameStream& stream) {
  constexpr std::chrono::milliseconds kPollInterval(50);
  for (;;) {
    check_interrupt();
    if (auto output = stream.receive_within(kPollInterval)) return std::move(*output);
  }
}

/// Sends one frame and waits for its output, with no other in flight. Throws Error if it is refused, and Interrupted.
inline client::FrameOutput run_frame(client::FrameStream& stream, const v1::Frame& frame) {
  check_interrupt();
  stream.send(frame);
  client::FrameOutput output = receive(stream);
  output.check();
  return output;
}

}  // namespace collided::cli
