// Meshes of a scene and their positions, in the form that a daemon takes.

#include "client/app/input/mesh_input.hpp"

#include <algorithm>

#include "client/cpp/positions.hpp"

namespace collided::cli {

std::vector<client::MeshInput> mesh_inputs(const std::vector<scenes::Mesh>& meshes) {
  std::vector<client::MeshInput> out;
  for (const scenes::Mesh& mesh : meshes)
    out.push_back({.name = mesh.name,
                   .vertex_count = mesh.vertex_count,
                   .triangles = mesh.triangles,
                   .is_static = mesh.is_static,
                   .edges = mesh.edges,
                   .points = mesh.points});
  return out;
}

void grow_box(v1::SceneSpec& spec, client::Positions positions) {
  if (!client::is_quantized(spec.position_format()) || positions.empty()) return;
  v1::QuantizationBox& box = *spec.mutable_quantization_box();
  for (const double x : positions[0])
    if (box.lower_size() < 3) box.add_lower(x), box.add_upper(x);
  for (const auto& position : positions)
    for (int axis = 0; axis < 3; ++axis) {
      const double x = position[static_cast<size_t>(axis)];
      box.set_lower(axis, std::min(box.lower(axis), x));
      box.set_upper(axis, std::max(box.upper(axis), x));
    }
}

v1::Frame make_frame(const std::vector<scenes::Mesh>& meshes, uint64_t id, const v1::SceneSpec& spec,
                     client::Positions end, client::Positions start) {
  v1::Frame frame;
  frame.set_frame_id(id);
  size_t at = 0;
  for (uint32_t i = 0; i < meshes.size(); ++i) {
    const scenes::Mesh& mesh = meshes[i];
    const bool has_start = !start.empty() && !mesh.is_static;
    const client::Positions own_start = has_start ? start.subspan(at, mesh.vertex_count) : client::Positions();
    if (id == 1 || !mesh.is_static)
      *frame.add_updates() = client::mesh_update(i, spec, end.subspan(at, mesh.vertex_count), own_start);
    at += mesh.vertex_count;
  }
  return frame;
}

}  // namespace collided::cli
