#include "gpu/tables/solids.hpp"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "gpu/base/text.hpp"

namespace collided {
namespace {

using Corners = std::array<uint32_t, 3>;

std::string count_of(uint64_t count, const char* noun) { return text(count) + ' ' + noun + (count == 1 ? "" : "s"); }

/// Returns what is wrong with the first edge that is not balanced.
std::optional<std::string> find_unbalanced_edge(const std::vector<Corners>& triangles) {
  // The lower vertex, the higher one, and a bit for the direction. Vertex ids have 29 bits (kMaxFeatures).
  std::vector<uint64_t> uses;
  uses.reserve(3 * triangles.size());
  for (const Corners& t : triangles)
    for (size_t k = 0; k < 3; ++k) {
      const uint64_t from = t[k], to = t[(k + 1) % 3];
      uses.push_back(std::min(from, to) << 32 | std::max(from, to) << 1 | (from > to));
    }
  std::sort(uses.begin(), uses.end());
  for (size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    uint64_t counts[2] = {0, 0};
    for (; end < uses.size() && uses[end] >> 1 == uses[begin] >> 1; ++end) ++counts[uses[end] & 1];
    if (counts[0] == counts[1]) continue;
    const std::string edge = "edge " + text(uses[begin] >> 32) + '-' + text((uses[begin] & 0xffffffff) >> 1) + " has ";
    if (counts[0] + counts[1] == 1) return edge + "1 triangle: the mesh is open";
    return edge + count_of(std::max(counts[0], counts[1]), "triangle") + " in one direction and " +
           text(std::min(counts[0], counts[1])) + " in the other";
  }
  return std::nullopt;
}

/// A triangle by its corners in ascending order, which of its two sides is its front, and its index.
struct Sided {
  Corners corners;
  bool is_reversed;
  uint32_t triangle;

  bool operator<(const Sided& other) const {
    return std::tie(corners, is_reversed, triangle) < std::tie(other.corners, other.is_reversed, other.triangle);
  }
};

Sided sided(Corners corners, uint32_t triangle) {
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  const bool is_reversed = corners[1] > corners[2];
  if (is_reversed) std::swap(corners[1], corners[2]);
  return {corners, is_reversed, triangle};
}

/// Returns the first triangle whose reverse is a triangle as well, with that one.
std::optional<std::pair<uint32_t, uint32_t>> find_fin(const std::vector<Corners>& triangles) {
  std::vector<Sided> sorted;
  sorted.reserve(triangles.size());
  for (uint32_t i = 0; i < triangles.size(); ++i) sorted.push_back(sided(triangles[i], i));
  std::sort(sorted.begin(), sorted.end());
  std::optional<std::pair<uint32_t, uint32_t>> first;
  const Sided* front = nullptr;  // the lowest of those with the same corners and front
  for (const Sided& t : sorted) {
    const bool has_same_corners = front != nullptr && front->corners == t.corners;
    if (has_same_corners && front->is_reversed == t.is_reversed) continue;
    if (has_same_corners) {
      const std::pair<uint32_t, uint32_t> fin = std::minmax(front->triangle, t.triangle);
      if (!first || fin < *first) first = fin;
    }
    front = &t;
  }
  return first;
}

}  // namespace

std::vector<uint32_t> solid_meshes(const SceneSpec& spec) {
  std::vector<uint32_t> solids;
  for (uint32_t mesh = 0; mesh < spec.meshes.size(); ++mesh)
    if (spec.meshes[mesh].solid) solids.push_back(mesh);
  return solids;
}

void check_solid(const MeshSpec& mesh, const std::string& field) {
  const auto refuse = [&](const std::string& reason) {
    throw InvalidInput(field + ".solid", field + ".solid is on, but " + reason);
  };
  const auto refuse_loose = [&](const auto& elements, const char* noun) {
    if (!elements.empty())
      refuse("the mesh has " + count_of(elements.size(), noun) + ": a solid is of triangles alone");
  };
  refuse_loose(mesh.edges, "loose edge");
  refuse_loose(mesh.points, "loose point");
  if (const auto reason = find_unbalanced_edge(mesh.triangles)) refuse(*reason);
  if (const auto fin = find_fin(mesh.triangles))
    refuse("triangle " + text(fin->second) + " is the reverse of triangle " + text(fin->first) +
           ": there is no volume between them");
}

}  // namespace collided
