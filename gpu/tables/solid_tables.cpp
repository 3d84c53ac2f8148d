#include "gpu/tables/solid_tables.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "gpu/contacts/kinds.hpp"
#include "gpu/tables/exclusions.hpp"

namespace collided {
namespace {

/// Which meshes may touch another one that is a solid, but for pairs of meshes that are excluded.
class TouchesSolids {
 public:
  explicit TouchesSolids(const SceneSpec& spec) : rules_(mesh_rules(spec)) {
    for (size_t mesh = 0; mesh < spec.meshes.size(); ++mesh)
      if (spec.meshes[mesh].solid) ++solids_of_[key_of(rules_[mesh])];
  }
  bool has(const SceneSpec& spec, size_t mesh) const {
    return std::any_of(solids_of_.begin(), solids_of_.end(), [&](const auto& of_rule) {
      const auto& [key, count] = of_rule;
      const bool is_alone = spec.meshes[mesh].solid && key == key_of(rules_[mesh]) && count == 1;
      const MeshRule rule{std::get<0>(key), std::get<1>(key), std::get<2>(key), 0};
      return !is_alone && may_touch(rules_[mesh], rule);
    });
  }

 private:
  using Key = std::tuple<uint32_t, uint32_t, uint32_t>;
  static Key key_of(const MeshRule& rule) { return {rule.groups, rule.collide_mask, rule.is_static}; }

  std::vector<MeshRule> rules_;
  std::map<Key, size_t> solids_of_;  ///< how many there are of each rule
};

std::vector<bool> used_vertices(const Topology& topology) {
  std::vector<bool> used(topology.vertex_count, false);
  for (const auto& corners : topology.triangles)
    for (const uint32_t vertex : corners) used[vertex] = true;
  return used;
}

/// Edges are sorted by their lower vertices, and so by their meshes.
std::vector<uint32_t> edge_offsets(const Topology& topology) {
  std::vector<uint32_t> offsets;
  for (const uint32_t vertex : topology.vertex_offset) {
    const auto first = std::lower_bound(topology.edges.begin(), topology.edges.end(), vertex,
                                        [](const auto& edge, uint32_t lowest) { return edge[0] < lowest; });
    offsets.push_back(static_cast<uint32_t>(first - topology.edges.begin()));
  }
  return offsets;
}

}  // namespace

SolidTables make_solid_tables(const SceneSpec& spec, const Topology& topology) {
  SolidTables tables;
  if (!looks_into_solids(spec) || !has_solids(spec)) return tables;
  const TouchesSolids touches_solids(spec);
  const std::vector<bool> used = used_vertices(topology);
  SolidMeshes& meshes = tables.meshes;
  meshes.topology = &topology;
  meshes.edge_offset = edge_offsets(topology);
  for (uint32_t mesh = 0; mesh < spec.meshes.size(); ++mesh) {
    const bool is_solid = spec.meshes[mesh].solid;
    const uint32_t solid = is_solid ? static_cast<uint32_t>(meshes.solids.size()) : MeshVertex::kNoSolid;
    meshes.are_solid.push_back(is_solid);
    if (is_solid) {
      meshes.solids.push_back(mesh);
      tables.first_places.push_back(static_cast<uint32_t>(tables.triangles.size()));
      for (uint32_t i = topology.triangle_offset[mesh]; i < topology.triangle_offset[mesh + 1]; ++i) {
        const auto& t = topology.triangles[i];
        tables.triangles.push_back({{t[0], t[1], t[2]}, mesh, solid, i});
      }
    }
    const bool may_be_inside = touches_solids.has(spec, mesh);
    meshes.used.push_back(0);
    for (uint32_t vertex = topology.vertex_offset[mesh]; vertex < topology.vertex_offset[mesh + 1]; ++vertex) {
      if (!used[vertex]) continue;
      ++meshes.used.back();
      if (may_be_inside) tables.vertices.push_back({vertex, mesh, solid});
    }
  }
  return tables;
}

}  // namespace collided
