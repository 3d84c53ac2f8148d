#pragma once
// The pairs of features that are within SceneSpec::rest_distance of each other in a scene's first frame. That frame
// finds them before its own step, with the same pipeline; as long as no frame counts, each begins anew.

#include "gpu/scene/exclusions.hpp"
#include "gpu/step/pipeline.hpp"

namespace collided {

template <Executor Exec, class Real>
class RestPairs {
 public:
  RestPairs(Exec& exec, const SceneSpec& spec, SceneBuffers<Exec, Real>& scene, Pipeline<Exec, Real>& pipeline)
      : exec_(exec), spec_(spec), are_wanted_(excludes_rest_pairs(spec)), scene_(scene), pipeline_(pipeline) {}

  bool are_wanted() const { return are_wanted_; }

  /// Of the positions at t = 1. Returns the step's replays.
  uint32_t find() {
    set_rules(rest_rules(spec_));
    const FrameResult near = pipeline_.detect_rest_pairs();
    set_rules(mesh_rules(spec_));
    exec_.stage("rest_pairs", [&] { keep(near); });
    return near.replays;
  }

 private:
  void set_rules(const std::vector<MeshRule>& rules) {
    exec_.upload(scene_.topology.rules.data(), rules.data(), rules.size() * sizeof(MeshRule));
    exec_.wait();
  }

  /// The slots fill the buffer, which an earlier frame that did not count may have made larger.
  void keep(const FrameResult& near) {
    Buffer<uint64_t, Exec>& resident = scene_.topology.rest_pairs;
    resident.allocate(key_slots(near.vertex_triangle.size() + near.edge_edge.size()));
    MemoryHold held(spec_.memory_quota);
    held.resize(resident.capacity() * sizeof(uint64_t));
    std::vector<uint64_t> slots(resident.capacity(), kNoKey);
    for (const auto& [vertex, triangle] : near.vertex_triangle.elements)
      add_key(slots, rest_key_of_vertex(vertex, triangle));
    for (const auto& [edge, other] : near.edge_edge.elements) add_key(slots, rest_key_of_edges(edge, other));
    exec_.upload(resident.data(), slots.data(), slots.size() * sizeof(uint64_t));
    exec_.wait();
  }

  Exec& exec_;
  const SceneSpec& spec_;
  const bool are_wanted_;
  SceneBuffers<Exec, Real>& scene_;
  Pipeline<Exec, Real>& pipeline_;
};

}  // namespace collided
