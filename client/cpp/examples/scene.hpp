#pragma once
// The example's meshes on a daemon.

#include <collided/client.hpp>
#include <span>
#include <vector>

#include "client/cpp/examples/shapes.hpp"

/// As they go on the wire.
inline std::vector<float> packed(const std::vector<Vec>& points) {
  std::vector<float> coordinates;
  for (const Vec& p : points)
    for (const double value : {p.x, p.y, p.z}) coordinates.push_back(static_cast<float>(value));
  return coordinates;
}

/// A scene of the floor, the sphere and the cloth.
class Scene {
 public:
  Scene(collided::client::Client& client, const collided::v1::SceneSpec& spec, std::span<const Mesh, 3> meshes)
      : stream_(open(client, spec, meshes)) {
    for (const Mesh& mesh : meshes) counts_.push_back(mesh.vertices.size());
  }

  /// A frame's answer. positions: of all vertices; none: where they are.
  collided::client::FrameOutput ask(const std::vector<float>& positions,
                                    const collided::client::FrameOptions& options) {
    std::vector<collided::client::FrameUpdate> updates;
    std::span<const float> rest = positions;
    for (uint32_t mesh = 0; mesh < 3 && !positions.empty(); ++mesh) {
      // The floor is static: only the first frame has it.
      if (mesh > 0 || id_ == 0)
        updates.push_back({.mesh = mesh, .positions = std::as_bytes(rest.first(3 * counts_[mesh]))});
      rest = rest.subspan(3 * counts_[mesh]);
    }
    stream_.send(++id_, updates, options);
    collided::client::FrameOutput output = stream_.receive();
    output.check();
    return output;
  }

 private:
  static collided::client::FrameStream open(collided::client::Client& client, const collided::v1::SceneSpec& spec,
                                            std::span<const Mesh, 3> meshes) {
    std::vector<collided::client::MeshInput> inputs;
    for (const char* name : {"floor", "sphere", "cloth"}) {
      const Mesh& mesh = meshes[inputs.size()];
      inputs.push_back(
          {.name = name, .vertex_count = static_cast<uint32_t>(mesh.vertices.size()), .triangles = mesh.triangles});
    }
    inputs[0].is_static = true;
    // The sphere is deformable: all that it does is sent as positions. It never meets itself.
    inputs[1].no_self_contacts = true;
    return client.stream(client.create_scene(spec, inputs));
  }

  collided::client::FrameStream stream_;
  std::vector<size_t> counts_;
  uint64_t id_ = 0;
};
