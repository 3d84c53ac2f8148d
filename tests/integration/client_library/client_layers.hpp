#pragma once
// Scenes of two layers through the client library.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "client/cpp/client.hpp"
#include "tests/integration/support/layers.hpp"

namespace collided::test {

using client::Client;
using client::FrameOutput;
using client::FrameStream;
using client::FrameUpdate;

inline constexpr uint32_t kSide = 40;

/// As layers_request() has it.
inline pb::Scene make_layers(Client& client, uint32_t side = kSide) {
  std::vector<std::array<uint32_t, 3>> triangles;
  const auto corners = layer_triangles(side);
  for (size_t i = 0; i < corners.size(); i += 3) triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  const client::MeshInput mesh{.name = "layers", .vertex_count = 2 * side * side, .triangles = triangles};
  auto spec = layers_request(side).spec();
  spec.clear_meshes();
  return client.create_scene(spec, {&mesh, 1});
}

/// The positions differ from frame to frame, and repeat after three.
inline std::string layers_at(uint64_t id, uint32_t side = kSide) {
  return pack_points(layer_points(side, kLayerGap * static_cast<double>(1 + id % 3)));
}

inline std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

inline FrameOutput ask(FrameStream& stream, uint64_t id, const FrameUpdate& update) {
  stream.send(id, {&update, 1});
  FrameOutput output = stream.receive();
  output.check();
  EXPECT_EQ(output.frame_id, id);
  return output;
}

inline FrameOutput ask_whole(FrameStream& stream, uint64_t id) {
  const std::string positions = layers_at(id);
  return ask(stream, id, {.positions = bytes_of(positions)});
}

}  // namespace collided::test
