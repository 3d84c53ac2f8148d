#pragma once
// A connection to a daemon: scenes and streams. Every function throws Error with the daemon's code and message.

#include <chrono>
#include <memory>
#include <span>
#include <string>

#include "client/cpp/error.hpp"
#include "client/cpp/frame_stream.hpp"
#include "collided/v1/collision_service.pb.h"

namespace collided::client {

/// A mesh of a scene to make. Its triangles are uploaded in chunks, however many there are.
struct MeshInput {
  std::string name;
  uint32_t vertex_count = 0;
  std::span<const std::array<uint32_t, 3>> triangles;
  bool is_static = false;
};

class Client {
 public:
  /// `address` is host:port or unix:/path. Waits for the connection. Throws Error (UNAVAILABLE) after `patience`.
  static Client connect(const std::string& address, std::chrono::milliseconds patience = std::chrono::seconds(5));
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;
  ~Client();

  const v1::GetServerInfoResponse& server_info() const;
  /// Makes a scene of `spec` (whose own meshes must be empty) and the meshes, ready for frames.
  v1::Scene create_scene(v1::SceneSpec spec, std::span<const MeshInput> meshes);
  v1::Scene get_scene(const std::string& scene_id);
  void delete_scene(const std::string& scene_id);
  /// Opens a stream; `window` 0 leaves the number of frames in flight to the daemon.
  FrameStream stream(const std::string& scene_id, uint32_t window = 0);

 private:
  struct State;
  explicit Client(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collided::client
