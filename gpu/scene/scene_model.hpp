#pragma once
// What a scene is made of, on the host and on its backend. An edit replaces all of it at once, and can be undone.

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/positions/slot.hpp"
#include "gpu/state/buffers.hpp"
#include "gpu/tables/exclusions.hpp"
#include "gpu/tables/solid_tables.hpp"
#include "gpu/tables/topology.hpp"

namespace collided {

template <Executor Exec, class Real>
class SceneModel {
 public:
  SceneModel(Exec& exec, SceneSpec spec, FeatureTables features) : exec_(exec), buffers_(exec) {
    take(std::move(spec), std::move(features));
  }
  SceneModel(const SceneModel&) = delete;
  SceneModel& operator=(const SceneModel&) = delete;

  /// Of one world.
  const Topology& topology() const { return topology_; }
  SceneCounts counts() const { return SceneCounts(topology_, shape_.spec.worlds); }
  /// It and its spec stay where they are, whatever edits make of them.
  const SceneShape& shape() const { return shape_; }
  const SceneSpec& spec() const { return shape_.spec; }
  /// A copy for slots, which may outlive the scene: theirs are of the scene as it is if they have this one.
  /// From any thread.
  std::shared_ptr<const SceneShape> slot_shape() const { return slot_shape_.load(); }
  SceneBuffers<Exec, Real>& buffers() { return buffers_; }

  /// A frame may ask for more accuracy than the scene.
  void require_edges() {
    if (buffers_.topology.edges.capacity() == 0) send(buffers_.topology.edges, topology_.edges);
  }

  /// All that an edit replaces.
  struct Parts {
    explicit Parts(Exec& exec) : buffers(exec) {}
    Topology topology;
    SceneShape shape;
    std::shared_ptr<const SceneShape> slot_shape;
    ResidentBuffers<Exec, Real> buffers;
  };
  /// Exchanges them. Throws nothing. Other threads make slots meanwhile, so their shape stays until there is another.
  void swap(Parts& parts) noexcept {
    std::swap(topology_, parts.topology);
    std::swap(shape_, parts.shape);
    auto before = slot_shape_.load();
    if (parts.slot_shape) slot_shape_ = std::move(parts.slot_shape);
    parts.slot_shape = std::move(before);
    std::swap(static_cast<ResidentBuffers<Exec, Real>&>(buffers_), parts.buffers);
  }
  /// Becomes what the spec says, with its vertices nowhere yet. After a throw its parts are of no use.
  void take(SceneSpec spec, FeatureTables features) {
    topology_ = std::move(features.topology);
    take(std::move(spec));
    ResidentTopology<Exec>& resident = buffers_.topology;
    send(resident.triangles, topology_.triangles);
    send_to_all_worlds(resident.owned, features.owned);
    const bool has_edges = have_edges(kinds_looked_for(this->spec()));
    if (has_edges) send(resident.triangle_edges, features.triangle_edges);
    if (has_edges && this->spec().accuracy != Accuracy::kCandidates) require_edges();
    send(resident.fan_begin, features.fans.begin);
    send(resident.fan_elements, features.fans.elements);
    send_rules(features.rings);
    send_halves();
    send_solids();
  }
  /// The same with the features of `before`.
  void take_rules(SceneSpec spec, const Parts& before, const RingTables& rings) {
    topology_ = before.topology;
    take(std::move(spec));
    copy(buffers_.topology.triangles, before.buffers.topology.triangles);
    copy(buffers_.topology.owned, before.buffers.topology.owned);
    copy(buffers_.topology.triangle_edges, before.buffers.topology.triangle_edges);
    copy(buffers_.topology.edges, before.buffers.topology.edges);
    copy(buffers_.topology.fan_begin, before.buffers.topology.fan_begin);
    copy(buffers_.topology.fan_elements, before.buffers.topology.fan_elements);
    send_rules(rings);
    send_halves();
    send_solids();
  }

 private:
  void take(SceneSpec spec) {
    for (MeshSpec& mesh : spec.meshes) mesh.triangles = {}, mesh.edges = {}, mesh.points = {};  // the tables hold them
    std::vector<uint32_t> vertex_offset = vertex_offsets(topology_, count_worlds(spec));
    shape_ = {std::move(spec), std::move(vertex_offset)};
    slot_shape_ = std::make_shared<const SceneShape>(shape_);
    const SceneCounts counts = this->counts();
    buffers_.topology.shape = counts.world_shape();
    buffers_.reserve_boxes(counts.triangles, 0);  // a number of vertices alone holds no memory before there is a frame
    if (counts.worlds > 0) buffers_.worlds.reserve(counts.worlds);
  }
  /// Which pairs are left out.
  void send_rules(const RingTables& rings) {
    ResidentTopology<Exec>& resident = buffers_.topology;
    if (needs_pair_filter(spec())) {
      send(resident.mesh_of_triangle, meshes_of_elements(topology_));
      send(resident.rules, mesh_rules(spec()));
      resident.branches = count_branches(spec());
      resident.idle = idle_meshes(spec());
      send(resident.excluded_meshes, excluded_mesh_slots(spec()));
    }
    send(resident.ring_begin, rings.begin);
    send(resident.ring_vertices, rings.vertices);
  }
  void send_halves() {
    const size_t meshes = spec().meshes.size();
    if (thickest_of(spec()) > 0 || tells_features(spec()))
      send(buffers_.topology.first_vertex,
           std::vector(shape_.vertex_offset.begin(), shape_.vertex_offset.begin() + meshes));
    if (thickest_of(spec()) == 0) return;
    std::vector<double> halves;
    for (const MeshSpec& mesh : spec().meshes) halves.push_back(mesh.half_thickness);
    send(buffers_.topology.half_thickness, halves);
  }
  void send_solids() {
    ResidentTopology<Exec>& resident = buffers_.topology;
    SolidTables tables = make_solid_tables(spec(), topology_);
    send(resident.solid_triangles, tables.triangles);
    send(resident.solid_places, tables.first_places);
    send(resident.solid_vertices, tables.vertices);
    resident.solids = std::move(tables.meshes);
  }
  static std::vector<uint32_t> vertex_offsets(const Topology& topology, uint32_t worlds) {
    std::vector<uint32_t> offsets = {0};
    offsets.reserve(uint64_t{worlds} * (topology.vertex_offset.size() - 1) + 1);
    for (uint32_t world = 0; world < worlds; ++world)
      for (size_t mesh = 1; mesh < topology.vertex_offset.size(); ++mesh)
        offsets.push_back(world * topology.vertex_count + topology.vertex_offset[mesh]);
    return offsets;
  }
  /// One copy after the other.
  template <class T>
  void send_to_all_worlds(Buffer<T, Exec>& to, const std::vector<T>& from) {
    to.allocate(from.size() * count_worlds(spec()));
    exec_.upload(to.data(), from.data(), from.size() * sizeof(T));
    for (uint64_t done = from.size(); done < to.capacity(); done *= 2)
      exec_.copy(to.data() + done, to.data(), min(done, to.capacity() - done) * sizeof(T));
  }
  template <class T, class U>
  void send(Buffer<T, Exec>& to, const std::vector<U>& from) {
    static_assert(sizeof(T) == sizeof(U));
    if (from.empty()) return;
    to.allocate(from.size());
    exec_.upload(to.data(), from.data(), from.size() * sizeof(T));
  }

  template <class T>
  void copy(Buffer<T, Exec>& to, const Buffer<T, Exec>& from) {
    if (from.capacity() == 0) return;
    to.allocate(from.capacity());
    exec_.copy(to.data(), from.data(), from.capacity() * sizeof(T));
  }

  Exec& exec_;
  Topology topology_;
  SceneShape shape_;
  std::atomic<std::shared_ptr<const SceneShape>> slot_shape_;
  SceneBuffers<Exec, Real> buffers_;
};

}  // namespace collided
