#include "gpu/tables/rings.hpp"

#include <algorithm>

#include "gpu/tables/exclusions.hpp"

namespace collided {
namespace {

/// How far the rings of each mesh reach, in edges.
std::vector<uint32_t> reaches_of(const SceneSpec& spec) {
  std::vector<uint32_t> reaches;
  const std::vector<MeshRule> rules = mesh_rules(spec);
  for (size_t i = 0; i < rules.size(); ++i)
    reaches.push_back(rules[i].has_self_contacts && !rules[i].is_static ? spec.meshes[i].excluded_rings : 0);
  return reaches;
}

/// Where the edges of each vertex lead.
RingTables neighbours_of(const Topology& topology) {
  RingTables out;
  out.begin.assign(size_t{topology.vertex_count} + 1, 0);
  for (const auto& edge : topology.edges)
    for (const uint32_t v : edge) ++out.begin[v];
  for (size_t v = 1; v < out.begin.size(); ++v) out.begin[v] += out.begin[v - 1];
  out.vertices.resize(2 * topology.edges.size());
  for (const auto& [a, b] : topology.edges) {
    out.vertices[--out.begin[a]] = b;
    out.vertices[--out.begin[b]] = a;
  }
  return out;
}

/// Breadth first from one vertex after the other.
class RingWalk {
 public:
  explicit RingWalk(const Topology& topology)
      : neighbours_(neighbours_of(topology)), reached_from_(topology.vertex_count, kNothing) {}

  /// The vertices that at most `reach` edges lead to from v, without v, in any order; until the next call.
  const std::vector<uint32_t>& ring(uint32_t v, uint32_t reach) {
    ring_.clear();
    reached_from_[v] = v;
    leave(v, v);
    size_t next = 0;
    for (uint32_t step = 1; step < reach; ++step)
      for (const size_t end = ring_.size(); next < end; ++next) leave(ring_[next], v);
    return ring_;
  }
  /// Along edges, so far.
  uint64_t steps() const { return steps_; }

 private:
  static constexpr uint32_t kNothing = ~0u;
  void leave(uint32_t at, uint32_t from) {
    const uint32_t first = neighbours_.begin[at], end = neighbours_.begin[at + 1];
    steps_ += end - first;
    for (uint32_t i = first; i < end; ++i) {
      const uint32_t to = neighbours_.vertices[i];
      if (reached_from_[to] == from) continue;
      reached_from_[to] = from;
      ring_.push_back(to);
    }
  }

  const RingTables neighbours_;
  std::vector<uint32_t> reached_from_;  ///< for each vertex the last one whose ring it is in
  std::vector<uint32_t> ring_;
  uint64_t steps_ = 0;
};

/// Of the walk; a ring, which grows by doubling, has no more than all vertices.
uint64_t walking_bytes(const Topology& topology) {
  return sizeof(uint32_t) * (4 * uint64_t{topology.vertex_count} + 1 + 2 * topology.edges.size());
}
uint64_t table_bytes(const Topology& topology, uint64_t entries) {
  return sizeof(uint32_t) * (uint64_t{topology.vertex_count} + 1 + entries);
}

size_t first_with_rings(const SceneSpec& spec) {
  return static_cast<size_t>(std::find_if(spec.meshes.begin(), spec.meshes.end(),
                                          [](const MeshSpec& mesh) { return mesh.excluded_rings > 0; }) -
                             spec.meshes.begin());
}

[[noreturn]] void refuse_rings(const SceneSpec& spec, size_t mesh, const std::string& what) {
  const std::string field = "meshes[" + std::to_string(mesh) + "].excluded_rings";
  throw InvalidInput(field, field + " is " + std::to_string(spec.meshes[mesh].excluded_rings) +
                                ", too many for these meshes, whose rings " + what);
}

void check_size(const SceneSpec& spec, const Topology& topology, uint64_t entries) {
  const uint64_t bytes = table_bytes(topology, entries);
  if (spec.memory_budget != 0 && bytes > spec.memory_budget)
    throw ResourceExhausted("memory_budget: the scene needs more than " + std::to_string(bytes) +
                            " bytes for the rings of its meshes, the budget is " + std::to_string(spec.memory_budget));
  if (entries >= ~0u)
    refuse_rings(spec, first_with_rings(spec), "have more than " + std::to_string(~0u - 1) + " vertices in all");
}

/// Many edges may lead to few vertices: what bounds the rings does not bound the way there. Meshes whose vertices have
/// six neighbours take 600 steps a triangle for eight rings.
uint64_t max_steps(const Topology& topology) {
  return (uint64_t{1} << 24) + 4096 * uint64_t{topology.triangles.size()};
}

/// use(vertex, its ring) for the vertices of meshes that have rings.
template <class Use>
void for_each_ring(const SceneSpec& spec, const Topology& topology, const std::vector<uint32_t>& reaches,
                   RingWalk& walk, Asks& asks, const Use& use) {
  constexpr uint64_t kStepsOfOneLook = 1 << 14;
  const uint64_t most = max_steps(topology);
  uint64_t next_look = walk.steps() + kStepsOfOneLook;
  for (size_t mesh = 0; mesh < reaches.size(); ++mesh)
    for (uint32_t v = topology.vertex_offset[mesh]; reaches[mesh] > 0 && v < topology.vertex_offset[mesh + 1]; ++v) {
      use(v, walk.ring(v, reaches[mesh]));
      if (walk.steps() >= next_look) {
        asks.ask_if_due();
        next_look = walk.steps() + kStepsOfOneLook;
      }
      if (walk.steps() > most)
        refuse_rings(spec, mesh, "take more than " + std::to_string(most) + " steps along edges");
    }
}

/// How many vertices all rings have; what they take is taken while they are counted, so that nobody counts for long
/// what cannot be held. Leaves the length of each ring in `lengths`.
uint64_t count_entries(const SceneSpec& spec, const Topology& topology, const std::vector<uint32_t>& reaches,
                       MemoryHold& making, Asks& asks, std::vector<uint32_t>& lengths) {
  constexpr uint64_t kAtATime = 1u << 20;
  uint64_t entries = 0, taken = 0;
  RingWalk walk(topology);
  for_each_ring(spec, topology, reaches, walk, asks, [&](uint32_t v, const std::vector<uint32_t>& ring) {
    lengths[v] = static_cast<uint32_t>(ring.size());
    entries += ring.size();
    if (entries <= taken) return;
    check_size(spec, topology, entries);
    const uint64_t more = std::max(entries - taken, kAtATime);
    making.resize(making.bytes() + sizeof(uint32_t) * more);
    taken += more;
  });
  return entries;
}

}  // namespace

RingTables make_neighbours(const Topology& topology, MemoryHold& making) {
  making.resize(making.bytes() + table_bytes(topology, 2 * topology.edges.size()));
  RingTables out = neighbours_of(topology);
  for (size_t v = 0; v + 1 < out.begin.size(); ++v)
    std::sort(out.vertices.begin() + out.begin[v], out.vertices.begin() + out.begin[v + 1]);
  return out;
}

RingTables make_rings(const SceneSpec& spec, const Topology& topology, MemoryHold& making, Asks& asks) {
  RingTables rings;
  const std::vector<uint32_t> reaches = reaches_of(spec);
  if (std::all_of(reaches.begin(), reaches.end(), [](uint32_t reach) { return reach == 0; })) return rings;
  const uint64_t before = making.bytes();
  making.resize(before + walking_bytes(topology) + table_bytes(topology, 0));
  rings.begin.assign(size_t{topology.vertex_count} + 1, 0);
  const uint64_t entries = count_entries(spec, topology, reaches, making, asks, rings.begin);
  uint32_t sum = 0;
  for (uint32_t& begin : rings.begin) sum += std::exchange(begin, sum);
  rings.vertices.reserve(entries);
  RingWalk walk(topology);
  for_each_ring(spec, topology, reaches, walk, asks, [&](uint32_t, const std::vector<uint32_t>& ring) {
    const auto first = static_cast<std::ptrdiff_t>(rings.vertices.size());
    rings.vertices.insert(rings.vertices.end(), ring.begin(), ring.end());
    std::sort(rings.vertices.begin() + first, rings.vertices.end());
  });
  making.resize(before + table_bytes(topology, entries));
  return rings;
}

}  // namespace collided
