#pragma once
// The pairs of features that are within SceneSpec::rest_distance of each other in their mesh's first frame. That frame
// finds them before its own step, with the same pipeline; as long as no frame counts, each begins anew.

#include <utility>
#include <vector>

#include "gpu/step/pipeline.hpp"
#include "gpu/tables/exclusions.hpp"
#include "gpu/tables/id_shift.hpp"

namespace collided {

template <Executor Exec, class Real>
class RestPairs {
 public:
  RestPairs(Exec& exec, const SceneSpec& spec, SceneBuffers<Exec, Real>& scene, Pipeline<Exec, Real>& pipeline)
      : exec_(exec),
        spec_(spec),
        scene_(scene),
        pipeline_(pipeline),
        rules_(rest_rules(spec, std::vector<bool>(spec.meshes.size(), true))) {}

  /// Whether the next frame is the first of a mesh that excludes such pairs.
  bool are_awaited() const { return may_touch(rules_); }

  /// Of the positions at t = 1. Returns the step's replays.
  uint32_t find() {
    set_rules(rules_);
    const FrameResult near = pipeline_.detect_rest_pairs();
    set_rules(mesh_rules(spec_));
    exec_.stage("rest_pairs", [&] { keep(near); });
    pipeline_.release_lists();  // this step finds more than those to come
    return near.replays;
  }

  /// The scene is that of an edit: pairs of meshes that begin anew are awaited, the others are those in `slots` of
  /// before.
  void edit(const Buffer<uint64_t, Exec>& slots, const IdShift& ids, const std::vector<bool>& begins_anew) {
    rules_ = rest_rules(spec_, begins_anew);
    kept_.clear();
    std::vector<uint64_t> before(slots.capacity());
    MemoryHold held(spec_.memory_quota);
    held.resize(2 * before.size() * sizeof(uint64_t));
    exec_.download(before.data(), slots.data(), before.size() * sizeof(uint64_t));
    for (const uint64_t key : before) {
      if (key == kNoKey) continue;
      const size_t mesh = ids.mesh_of(key);
      if (spec_.meshes[mesh].excludes_rest_pairs && !begins_anew[mesh]) kept_.push_back(ids.shifted(key, mesh));
    }
    if (!are_awaited()) exec_.stage("rest_pairs", [&] { fill(kept_); });
  }
  /// The frame counts, or the edit does not.
  void settle() {
    rules_.clear();
    kept_ = {};
  }

 private:
  void set_rules(const std::vector<MeshRule>& rules) {
    exec_.upload(scene_.topology.rules.data(), rules.data(), rules.size() * sizeof(MeshRule));
    exec_.wait();
  }

  void keep(const FrameResult& near) {
    MemoryHold held(spec_.memory_quota);
    held.resize((kept_.size() + near.vertex_triangle.size() + near.edge_edge.size()) * sizeof(uint64_t));
    std::vector<uint64_t> keys = kept_;
    for (const auto& [vertex, triangle] : near.vertex_triangle.elements)
      keys.push_back(rest_key_of_vertex(vertex, triangle));
    for (const auto& [edge, other] : near.edge_edge.elements) keys.push_back(rest_key_of_edges(edge, other));
    fill(keys);
  }

  /// The slots fill the buffer, which an earlier frame that did not count may have made larger.
  void fill(const std::vector<uint64_t>& keys) {
    Buffer<uint64_t, Exec>& resident = scene_.topology.rest_pairs;
    resident.allocate(key_slots(keys.size()));
    MemoryHold held(spec_.memory_quota);
    held.resize(resident.capacity() * sizeof(uint64_t));
    std::vector<uint64_t> slots(resident.capacity(), kNoKey);
    for (const uint64_t key : keys) add_key(slots, key);
    exec_.upload(resident.data(), slots.data(), slots.size() * sizeof(uint64_t));
    exec_.wait();
  }

  Exec& exec_;
  const SceneSpec& spec_;
  SceneBuffers<Exec, Real>& scene_;
  Pipeline<Exec, Real>& pipeline_;
  std::vector<MeshRule> rules_;  ///< of the step that finds them; none touches: no pairs are awaited
  std::vector<uint64_t> kept_;   ///< pairs of meshes that an edit left as they were
};

}  // namespace collided
