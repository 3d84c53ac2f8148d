// The meshes of a scene, and their triangles, from the protocol to the engine.
#include "server/convert/meshes.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <set>

#include "server/convert/options.hpp"
#include "server/convert/refuse.hpp"
#include "server/field_path.hpp"

namespace collided::server {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian and is copied as it is");

constexpr size_t kTriangleBytes = sizeof(TriangleCorners);

// What is wrong with a triangle, or empty.
std::string check_triangle(const TriangleCorners& t, uint32_t vertex_count) {
  for (const uint32_t vertex : t)
    if (vertex >= vertex_count) return fmt::format("has vertex {}, but the mesh has {} vertices", vertex, vertex_count);
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
    return fmt::format("has a corner twice: {} {} {}", t[0], t[1], t[2]);
  return {};
}

uint64_t inline_triangles(const pb::MeshSpec& mesh) { return mesh.triangles().size() / kTriangleBytes; }

uint64_t total_triangles(const pb::MeshSpec& mesh) {
  return std::max<uint64_t>(mesh.triangle_count(), inline_triangles(mesh));
}

void check_triangle_count(const pb::MeshSpec& mesh, const std::string& path) {
  if (total_triangles(mesh) == 0)
    throw_invalid(path + ".triangles", "is empty and triangle_count is 0, but a mesh needs a triangle");
  if (mesh.triangle_count() > 0 && mesh.triangle_count() < inline_triangles(mesh))
    throw_invalid(
        path + ".triangle_count",
        fmt::format("is {}, but {}.triangles already has {}: it is the total, including those that UploadMesh sends",
                    mesh.triangle_count(), path, inline_triangles(mesh)));
}

// The engine's rest_distance is what it says; the protocol's 0 is the thickness, where a mesh uses it at all.
double parse_rest_distance(const pb::SceneSpec& spec) {
  const bool is_used =
      std::any_of(spec.meshes().begin(), spec.meshes().end(), [](const auto& m) { return m.exclude_rest_pairs(); });
  return spec.rest_distance() == 0 && is_used ? spec.thickness() : spec.rest_distance();
}

void check_total(const char* what, uint64_t total, uint64_t limit, const std::string& field) {
  if (total > limit)
    throw LimitExceeded(field,
                        fmt::format("{} has {} {} in all, more than max_{}, {}", field, total, what, what, limit));
}

}  // namespace

void for_each_triangle(std::string_view bytes, uint32_t vertex_count, const TrianglePath& path,
                       const std::function<void(const TriangleCorners&)>& take) {
  if (bytes.size() % kTriangleBytes)
    throw_invalid(path.field, fmt::format("has {} bytes, which is not a multiple of {}", bytes.size(), kTriangleBytes));
  for (size_t i = 0; i < bytes.size() / kTriangleBytes; ++i) {
    TriangleCorners triangle;
    std::memcpy(triangle.data(), bytes.data() + i * kTriangleBytes, kTriangleBytes);
    if (const auto wrong = check_triangle(triangle, vertex_count); !wrong.empty())
      throw_invalid(fmt::format("{}[{}]", path.field, path.first + i), wrong);
    take(triangle);
  }
}

void check_mesh_name(const std::string& name, const std::string& path) {
  if (name.empty() || name.size() > kMaxNameBytes)
    throw_invalid(path, fmt::format("has {} bytes, but must have 1 to {}", name.size(), kMaxNameBytes));
}

MeshSpec parse_mesh(const pb::MeshSpec& mesh, const std::string& path) {
  if (mesh.vertex_count() < 3)
    throw_invalid(path + ".vertex_count", fmt::format("is {}, but must be at least 3", mesh.vertex_count()));
  MeshSpec out;
  out.vertex_count = mesh.vertex_count();
  out.motion = parse_motion(mesh.motion(), path + ".motion");
  out.groups = mesh.groups() ? mesh.groups() : 1;
  out.collide_mask = mesh.collide_mask() ? mesh.collide_mask() : ~0u;
  out.self_contacts = !mesh.no_self_contacts();
  out.excluded_rings = mesh.exclude_rings();
  out.excludes_rest_pairs = mesh.exclude_rest_pairs();
  out.triangles.reserve(inline_triangles(mesh));
  for_each_triangle(mesh.triangles(), out.vertex_count, {path + ".triangles"},
                    [&](const TriangleCorners& triangle) { out.triangles.push_back(triangle); });
  return out;
}

void check_sizes(size_t meshes, const SceneSize& size, const Limits& limits, const std::string& field) {
  if (meshes > kMaxMeshes)
    throw LimitExceeded(field, fmt::format("{} has {} meshes, more than the limit of {}", field, meshes, kMaxMeshes));
  check_total("vertices", size.vertices, limits.max_vertices, field);
  check_total("triangles", size.triangles, limits.max_triangles, field);
}

SceneSize check_sizes(const pb::SceneSpec& spec, const Limits& limits) {
  if (spec.meshes().empty()) throw_invalid("spec.meshes", "is empty, but a scene needs a mesh");
  SceneSize size;
  for (const auto& mesh : spec.meshes()) {
    size.vertices += mesh.vertex_count();
    size.triangles += total_triangles(mesh);
  }
  check_sizes(static_cast<size_t>(spec.meshes_size()), size, limits, "spec.meshes");
  return size;
}

void parse_meshes(const pb::SceneSpec& spec, ScenePlan& plan) {
  std::set<std::string> names;
  for (int i = 0; i < spec.meshes_size(); ++i) {
    const auto& mesh = spec.meshes(i);
    const std::string path = fmt::format("spec.meshes[{}]", i);
    check_mesh_name(mesh.name(), path + ".name");
    plan.engine.meshes.push_back(parse_mesh(mesh, path));
    check_triangle_count(mesh, path);
    plan.meshes.push_back({mesh.name(), total_triangles(mesh), total_triangles(mesh) - inline_triangles(mesh)});
    if (!names.insert(mesh.name()).second)
      throw_invalid(path + ".name", fmt::format("is \"{}\", which an earlier mesh already has", mesh.name()));
  }
}

void parse_exclusions(const pb::SceneSpec& spec, ScenePlan& plan) try {
  plan.engine.rest_distance = parse_rest_distance(spec);
  for (const auto& pair : spec.excluded_meshes()) plan.engine.excluded_meshes.push_back({pair.first(), pair.second()});
  check_exclusions(plan.engine);
} catch (const InvalidInput& e) {
  throw with_path(e, spec_path);
}

}  // namespace collided::server
