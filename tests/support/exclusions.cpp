#include "tests/support/exclusions.hpp"

#include <algorithm>
#include <set>

namespace collided::test {
namespace {

constexpr uint8_t kFar = kMaxRings + 1;

}  // namespace

Exclusions::Exclusions(const Case& rest, const SceneSpec& spec) : spec_(spec), rest_(rest) { count_edges(); }

bool Exclusions::has(ContactKind kind, uint32_t first, uint32_t second) const {
  const std::vector<uint32_t> a = vertices_of(kind, first, true), b = vertices_of(kind, second, false);
  const uint32_t i = rest_.features().mesh_of_vertex[a[0]], j = rest_.features().mesh_of_vertex[b[0]];
  if (!may_touch(spec_, i, j)) return true;
  if (i != j) return false;
  const MeshSpec& mesh = spec_.meshes[i];
  if (mesh.excluded_rings > 0 && are_connected(a, b, mesh.excluded_rings)) return true;
  return mesh.excludes_rest_pairs && are_close_at_rest(kind, key_of(first, second));
}

PairSet Exclusions::left_of(ContactKind kind, const PairSet& pairs) const {
  PairSet left;
  const auto keep = [&](const std::vector<PairKey>& from, std::vector<PairKey>& to) {
    for (const PairKey key : from)
      if (!has(kind, static_cast<uint32_t>(key >> 32), static_cast<uint32_t>(key))) to.push_back(key);
  };
  keep(pairs.must, left.must);
  keep(pairs.may, left.may);
  return left;
}

ContactSet Exclusions::left_of(ContactKind kind, const ContactSet& contacts) const {
  std::vector<size_t> places;
  for (size_t i = 0; i < contacts.size(); ++i)
    if (!has(kind, contacts.elements[i][0], contacts.elements[i][1])) places.push_back(i);
  ContactSet left;
  for_each_field(
      [&](ContactField, auto& column, const auto& all) {
        std::vector<std::decay_t<decltype(all[0])>> values;
        if (!all.empty())
          for (const size_t place : places) values.push_back(all[place]);
        column = {std::move(values)};
      },
      left, contacts);
  return left;
}

std::vector<uint32_t> Exclusions::vertices_of(ContactKind kind, uint32_t id, bool is_first) const {
  const Features& f = rest_.features();
  if (kind == ContactKind::kEdgeEdge) return {f.edges[id][0], f.edges[id][1]};
  if (kind == ContactKind::kVertexTriangle && is_first) return {id};
  return {f.triangles[id][0], f.triangles[id][1], f.triangles[id][2]};
}

bool Exclusions::are_connected(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b, uint32_t edges) const {
  for (const uint32_t v : a)
    for (const uint32_t w : b)
      if (edges_between_[v][w] <= edges) return true;
  return false;
}

bool Exclusions::are_close_at_rest(ContactKind kind, PairKey pair) const {
  if (kind == ContactKind::kTriangleTriangle) return false;
  const QueryKind query = kind == ContactKind::kEdgeEdge ? QueryKind::kEdgeEdge : QueryKind::kVertexTriangle;
  const Query q = rest_.of_pair(query, pair);
  const double half = spec_.meshes[rest_.features().mesh_of_vertex[rest_.vertices_of(query, pair)[0]]].half_thickness;
  const Thickness within =
      spec_.rest_distance > 0 ? Thickness(spec_.rest_distance) : Thickness(spec_.thickness, half, half);
  return judge_proximity(query, {q.p[4], q.p[5], q.p[6], q.p[7]}, within);
}

// Row by row: one vertex, those beside it, those beside them, ...
void Exclusions::count_edges() {
  const size_t count = rest_.features().mesh_of_vertex.size();
  std::vector<std::set<uint32_t>> beside(count);
  for (const auto& [v, w] : rest_.features().edges) beside[v].insert(w), beside[w].insert(v);
  edges_between_.assign(count, std::vector<uint8_t>(count, kFar));
  for (uint32_t v = 0; v < count; ++v) {
    std::vector<uint8_t>& row = edges_between_[v];
    std::set<uint32_t> reached{v};
    for (uint8_t edges = 0; edges < kFar; ++edges) {
      std::set<uint32_t> next;
      for (const uint32_t w : reached) {
        if (row[w] < edges) continue;
        row[w] = edges;
        next.insert(beside[w].begin(), beside[w].end());
      }
      reached = std::move(next);
    }
  }
}

bool may_touch(const SceneSpec& spec, uint32_t mesh, uint32_t other) {
  const MeshSpec &a = spec.meshes[mesh], &b = spec.meshes[other];
  if (a.motion == MeshMotion::kStatic && b.motion == MeshMotion::kStatic) return false;
  for (const auto& pair : spec.excluded_meshes)
    if (pair == std::array{mesh, other} || pair == std::array{other, mesh}) return false;
  if (mesh == other && !a.self_contacts) return false;
  return (a.groups & b.collide_mask) != 0 && (b.groups & a.collide_mask) != 0;
}

SceneSpec full_model(SceneSpec spec) {
  for (MeshSpec& mesh : spec.meshes) {
    mesh.groups = 1;
    mesh.collide_mask = ~0u;
    mesh.self_contacts = true;
    mesh.excluded_rings = 0;
    mesh.excludes_rest_pairs = false;
  }
  spec.excluded_meshes.clear();
  spec.rest_distance = 0;
  return spec;
}

}  // namespace collided::test
