// The meshes of a scene, and their elements, from the protocol to the engine.
#include "server/convert/meshes.hpp"

#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <set>

#include "server/convert/options.hpp"
#include "server/refusals/field_path.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian and is copied as it is");

template <size_t N>
using Vertices = std::array<uint32_t, N>;

// What is wrong with an element, or empty.
template <size_t N>
std::string check_element(const Vertices<N>& element, uint32_t vertex_count) {
  for (const uint32_t vertex : element)
    if (vertex >= vertex_count) return fmt::format("has vertex {}, but the mesh has {} vertices", vertex, vertex_count);
  Vertices<N> sorted = element;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) return {};
  return fmt::format("has a {} twice: {}", N == 3 ? "corner" : "vertex", fmt::join(element, " "));
}

// Checks each element of a packed uint32[n][N] array and hands it to `take`.
template <size_t N, class Take>
void for_each_element(std::string_view bytes, uint32_t vertex_count, const TrianglePath& path, const Take& take) {
  constexpr size_t kBytes = sizeof(Vertices<N>);
  if (bytes.size() % kBytes)
    throw_invalid(path.field, fmt::format("has {} bytes, which is not a multiple of {}", bytes.size(), kBytes));
  for (size_t i = 0; i < bytes.size() / kBytes; ++i) {
    Vertices<N> element;
    std::memcpy(element.data(), bytes.data() + i * kBytes, kBytes);
    if (const auto wrong = check_element(element, vertex_count); !wrong.empty())
      throw_invalid(fmt::format("{}[{}]", path.field, path.first + i), wrong);
    take(element);
  }
}

uint64_t inline_triangles(const pb::MeshSpec& mesh) { return mesh.triangles().size() / sizeof(Vertices<3>); }
uint64_t count_edges(const pb::MeshSpec& mesh) { return mesh.edges().size() / sizeof(Vertices<2>); }
uint64_t count_points(const pb::MeshSpec& mesh) { return mesh.points().size() / sizeof(Vertices<1>); }

uint64_t total_triangles(const pb::MeshSpec& mesh) {
  return std::max<uint64_t>(mesh.triangle_count(), inline_triangles(mesh));
}

// `count`: 0, or what `array` has.
void check_count(const std::string& path, const char* array, const char* field, uint64_t count, uint64_t in_array) {
  if (count != 0 && count != in_array)
    throw_invalid(path + "." + field, fmt::format("is {}, but {}.{} has {}: UploadMesh sends triangles alone", count,
                                                  path, array, in_array));
}

// Names the mesh, as an upload does: people do not count meshes.
void parse_triangles(const pb::MeshSpec& mesh, const std::string& path, MeshSpec& out) try {
  out.triangles.reserve(inline_triangles(mesh));
  for_each_triangle(mesh.triangles(), out.vertex_count, {path + ".triangles"},
                    [&](const TriangleCorners& triangle) { out.triangles.push_back(triangle); });
} catch (const InvalidInput& e) {
  if (mesh.name().empty()) throw;
  throw InvalidInput(e.field(), fmt::format("{}, in mesh \"{}\"", e.what(), mesh.name()));
}

void parse_loose_elements(const pb::MeshSpec& mesh, const std::string& path, MeshSpec& out) {
  out.edges.reserve(count_edges(mesh));
  for_each_element<2>(mesh.edges(), out.vertex_count, {path + ".edges"},
                      [&](const Vertices<2>& edge) { out.edges.push_back(edge); });
  check_count(path, "edges", "edge_count", mesh.edge_count(), out.edges.size());
  out.points.reserve(count_points(mesh));
  for_each_element<1>(mesh.points(), out.vertex_count, {path + ".points"},
                      [&](const Vertices<1>& point) { out.points.push_back(point[0]); });
  check_count(path, "points", "point_count", mesh.point_count(), out.points.size());
}

void check_vertex_count(const pb::MeshSpec& mesh, const std::string& path) {
  const uint32_t least = total_triangles(mesh) > 0 ? 3 : 1;
  if (mesh.vertex_count() < least)
    throw_invalid(path + ".vertex_count", fmt::format("is {}, but must be at least {}", mesh.vertex_count(), least));
}

void check_triangle_count(const pb::MeshSpec& mesh, const std::string& path) {
  if (total_triangles(mesh) + count_edges(mesh) + count_points(mesh) == 0)
    throw_invalid(path + ".triangles",
                  "is empty and triangle_count is 0, but a mesh without edges and points needs a triangle");
  if (mesh.triangle_count() > 0 && mesh.triangle_count() < inline_triangles(mesh))
    throw_invalid(
        path + ".triangle_count",
        fmt::format("is {}, but {}.triangles already has {}: it is the total, including those that UploadMesh sends",
                    mesh.triangle_count(), path, inline_triangles(mesh)));
}

void check_total(const char* what, uint64_t total, const char* limit_name, uint64_t limit, const std::string& field) {
  if (total > limit)
    throw LimitExceeded(field,
                        fmt::format("{} has {} {} in all, more than {}, {}", field, total, what, limit_name, limit));
}

}  // namespace

void for_each_triangle(std::string_view bytes, uint32_t vertex_count, const TrianglePath& path,
                       const std::function<void(const TriangleCorners&)>& take) {
  for_each_element<3>(bytes, vertex_count, path, take);
}

void check_mesh_name(const std::string& name, const std::string& path) {
  if (name.empty() || name.size() > kMaxNameBytes)
    throw_invalid(path, fmt::format("has {} bytes, but must have 1 to {}", name.size(), kMaxNameBytes));
}

MeshSpec parse_mesh(const pb::MeshSpec& mesh, const std::string& path) {
  check_vertex_count(mesh, path);
  MeshSpec out;
  out.vertex_count = mesh.vertex_count();
  out.motion = parse<MeshMotion>(mesh.motion(), path + ".motion").value_or(MeshMotion::kDeformable);
  out.groups = mesh.groups() ? mesh.groups() : 1;
  out.collide_mask = mesh.collide_mask() ? mesh.collide_mask() : ~0u;
  out.self_contacts = !mesh.no_self_contacts();
  out.excluded_rings = mesh.exclude_rings();
  out.excludes_rest_pairs = mesh.exclude_rest_pairs();
  out.half_thickness = mesh.half_thickness();
  out.solid = mesh.solid();
  parse_triangles(mesh, path, out);
  parse_loose_elements(mesh, path, out);
  return out;
}

void check_sizes(size_t meshes, const SceneSize& size, const Limits& limits, const std::string& field) {
  if (meshes > kMaxMeshes)
    throw LimitExceeded(field, fmt::format("{} has {} meshes, more than the limit of {}", field, meshes, kMaxMeshes));
  check_total("vertices", size.vertices, "max_vertices", limits.max_vertices, field);
  check_total(size.names_of_elements(), size.elements(), "max_triangles", limits.max_triangles, field);
}

SceneSize check_sizes(const pb::SceneSpec& spec, const Limits& limits) {
  if (spec.meshes().empty()) throw_invalid("spec.meshes", "is empty, but a scene needs a mesh");
  SceneSize size;
  for (const auto& mesh : spec.meshes()) {
    size.vertices += mesh.vertex_count();
    size.triangles += total_triangles(mesh);
    size.loose += count_edges(mesh) + count_points(mesh);
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
    plan.meshes.push_back({mesh.name(), total_triangles(mesh), total_triangles(mesh) - inline_triangles(mesh),
                           count_edges(mesh), count_points(mesh)});
    if (!names.insert(mesh.name()).second)
      throw_invalid(path + ".name", fmt::format("is \"{}\", which an earlier mesh already has", mesh.name()));
  }
}

void parse_exclusions(const pb::SceneSpec& spec, ScenePlan& plan) try {
  for (const auto& pair : spec.excluded_meshes()) plan.engine.excluded_meshes.push_back({pair.first(), pair.second()});
  check_exclusions(plan.engine);
} catch (const InvalidInput& e) {
  throw with_path_in(e, spec);
}

}  // namespace collided::server
