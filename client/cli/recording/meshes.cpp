// The meshes of a recorded scene.

#include "client/cli/recording/meshes.hpp"

#include <cstring>
#include <stdexcept>

namespace collided::cli {

namespace {

template <class T>
void unpack(const std::string& bytes, std::vector<T>& out, int mesh, const char* field) {
  if (bytes.size() % sizeof(T) != 0)
    throw std::runtime_error("the recorded meshes[" + std::to_string(mesh) + "]." + field + " has " +
                             std::to_string(bytes.size()) + " bytes; it needs a multiple of " +
                             std::to_string(sizeof(T)));
  out.resize(bytes.size() / sizeof(T));
  if (!out.empty()) std::memcpy(out.data(), bytes.data(), bytes.size());
}

}  // namespace

RecordedMeshes::RecordedMeshes(const v1::SceneSpec& spec) : elements_(static_cast<size_t>(spec.meshes_size())) {
  for (int i = 0; i < spec.meshes_size(); ++i) {
    const v1::MeshSpec& mesh = spec.meshes(i);
    Elements& own = elements_[static_cast<size_t>(i)];
    unpack(mesh.triangles(), own.triangles, i, "triangles");
    unpack(mesh.edges(), own.edges, i, "edges");
    unpack(mesh.points(), own.points, i, "points");
    inputs_.push_back({.name = mesh.name(),
                       .vertex_count = mesh.vertex_count(),
                       .triangles = own.triangles,
                       .is_static = mesh.motion() == v1::MESH_MOTION_STATIC,
                       .is_rigid = mesh.motion() == v1::MESH_MOTION_RIGID,
                       .exclude_rings = mesh.exclude_rings(),
                       .exclude_rest_pairs = mesh.exclude_rest_pairs(),
                       .edges = own.edges,
                       .points = own.points,
                       .groups = mesh.groups(),
                       .collide_mask = mesh.collide_mask(),
                       .no_self_contacts = mesh.no_self_contacts(),
                       .half_thickness = mesh.half_thickness(),
                       .solid = mesh.solid()});
  }
}

}  // namespace collided::cli
