#pragma once
// A scene whose frames take long and whose answers are large: two square grids, one just above the other.

#include <string>
#include <vector>

#include "tests/integration/support/calls.hpp"
#include "tests/integration/support/positions.hpp"

namespace collided::test {

constexpr double kLayerGap = 0.001;   // within the thickness: every cell of the grid has contacts
constexpr double kLayersApart = 0.1;  // no contact at all

/// Two grids of side 1 with side * side vertices each.
inline Points layer_points(uint32_t side, double gap = kLayerGap) {
  Points points;
  for (const double z : {0.0, gap})
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) points.push_back({double(x) / side, double(y) / side, z});
  return points;
}

inline std::vector<uint32_t> layer_triangles(uint32_t side) {
  std::vector<uint32_t> triangles;
  for (uint32_t row = 0; row < 2 * side; ++row)
    for (uint32_t x = 0; row % side + 1 < side && x + 1 < side; ++x) {
      const uint32_t i = row * side + x, up = i + side;
      triangles.insert(triangles.end(), {i, i + 1, up, up + 1, up, i + 1});
    }
  return triangles;
}

/// DCD; the thickness is less than the distance of vertices within a layer.
inline pb::CreateSceneRequest layers_request(uint32_t side, double lease_seconds = 0) {
  pb::CreateSceneRequest request;
  request.set_lease_seconds(lease_seconds);
  auto* spec = request.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_DCD);
  spec->set_thickness(0.5 / side);
  auto* mesh = spec->add_meshes();
  mesh->set_name("layers");
  mesh->set_vertex_count(2 * side * side);
  mesh->set_triangles(pack(layer_triangles(side)));
  return request;
}

inline pb::Frame layers_frame(uint64_t id, const std::string& positions) {
  pb::Frame frame;
  frame.set_frame_id(id);
  frame.add_updates()->set_positions(positions);
  return frame;
}

}  // namespace collided::test
