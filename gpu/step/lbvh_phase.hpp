#pragma once
// The stages of the linear bounding volume hierarchy (lbvh/lbvh.hpp), from boxes to pairs: the other broad phase.

#include <algorithm>
#include <bit>

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/search/boxes.hpp"
#include "gpu/search/searcher.hpp"
#include "gpu/step/buffers.hpp"
#include "gpu/step/measure_worlds.hpp"

namespace collided {

template <Executor Exec, class Real>
class LbvhPhase {
 public:
  LbvhPhase(Exec& exec, Searcher<Exec>& searcher, const SceneCounts& counts, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), searcher_(searcher), counts_(counts), scene_(scene) {}

  /// What the next steps are like.
  void begin(double thickness, bool is_ccd) { thickness_ = thickness, is_ccd_ = is_ccd; }

  void reserve() { scene_.bvh.reserve(leaves(), keeps_meshes()); }

  /// How large the scene and its triangles are.
  void measure() {
    StepState* state = scene_.state.data();
    measure_bounds(exec_, scene_.size(leaves()));
    measure_extents(exec_, scene_.size(leaves()), PrepareNarrow{state, thickness_, scene_.deviations(is_ccd_)});
    if (has_worlds()) measure_worlds();
    scene_.leave_out_idle(exec_, leaves());
  }

  /// The leaves in order, and what is above them.
  void build() {
    exec_.stage("sort", [&] { sort(); });
    exec_.stage("hierarchy", [&] { join(); });
  }

  void sort() {
    BvhBuffers<Exec>& bvh = scene_.bvh;
    sorted_ = exec_.sort_pairs("sort_leaves", has_worlds() ? key_worlds() : key_all(),
                               {bvh.keys[0].span(leaves()), bvh.keys[1].span(leaves()), bvh.triangles[0].span(leaves()),
                                bvh.triangles[1].span(leaves())});
  }

  void join() {
    BvhBuffers<Exec>& bvh = scene_.bvh;
    exec_.for_each("build_hierarchy", leaves(),
                   BuildHierarchy{{bvh.keys[sorted_].all(), static_cast<uint32_t>(leaves()), leaves_of_world()},
                                  bvh.triangles[sorted_].all(),
                                  boxes(),
                                  bvh.meeting.all(),
                                  bvh.nodes.all(),
                                  scene_.topology.filter(),
                                  meshes_below()});
  }

  /// What the walks of all leaves find goes to the sink. `counts_tests`: once for each step.
  template <class Sink>
  void search(const char* name, const Sink& sink, uint64_t* next_item, bool counts_tests) {
    StepState* state = scene_.state.data();
    const BvhPairs source{scene_.bvh.nodes.all(), static_cast<uint32_t>(leaves()),
                          scene_.pair_filter(),   counts_tests ? &state->leaves[LeafSum::kTests] : nullptr,
                          leaves_of_world(),      meshes_below()};
    searcher_.walk(name, leaves(), next_item, source, sink);
  }

  /// Nodes take the place of cells; nothing is registered.
  void describe(FrameCounts& counts) const {
    counts.cells = 2 * leaves() - max(counts_.worlds, 1u);
    counts.leaves = leaves();
  }

 private:
  uint64_t leaves() const { return counts_.triangles; }
  bool has_worlds() const { return counts_.worlds > 0; }
  /// 0: the scene is one.
  uint32_t leaves_of_world() const { return has_worlds() ? counts_.world_shape().triangles : 0; }
  Span<const Box<float>> boxes() const { return scene_.boxes.span(leaves()); }
  bool keeps_meshes() const { return scene_.topology.branches > 0; }
  Span<MeshesTogether> meshes_below() const {
    return keeps_meshes() ? scene_.bvh.meshes.all() : Span<MeshesTogether>{};
  }
  /// `used`: bits of the keys without them. Where the branches need more than are left, all are in one.
  BvhBranches branches(int used) const {
    const uint32_t count = scene_.topology.branches;
    const int bits = count > 1 ? std::bit_width(count - 1) : 0;
    return {scene_.topology.filter(), bits <= std::min(BvhBranches::kMaxBits, 64 - used) ? bits : 0};
  }

  void measure_worlds() {
    WorldBuffers<Exec>& worlds = scene_.worlds;
    exec_.for_each_group("measure_worlds", {nullptr, counts_.worlds},
                         MeasureWorlds{boxes(), leaves_of_world(), thickness_, worlds.bounds.data(),
                                       worlds.extents.data(), worlds.filters.data()});
  }
  /// The leaves' keys; returns their bits.
  int key_worlds() {
    BvhBuffers<Exec>& bvh = scene_.bvh;
    const int axis_bits = WorldMortonKeys::axis_bits_for(leaves_of_world());
    const int bits = WorldMortonKeys::bits(axis_bits, counts_.worlds);
    const BvhBranches branches = this->branches(bits);
    exec_.for_each("morton_keys", leaves(),
                   WorldMortonKeys{scene_.worlds.bounds.data(), scene_.worlds.extents.data(), scene_.stepped_worlds(),
                                   boxes(), bvh.keys[0].span(leaves()), bvh.triangles[0].span(leaves()),
                                   bvh.meeting.all(), axis_bits, branches});
    return bits + branches.bits;
  }
  int key_all() {
    const StepState* state = scene_.state.data();
    BvhBuffers<Exec>& bvh = scene_.bvh;
    const MortonKeys keys{&state->bounds,
                          {&state->bounds, &state->extents, leaves()},
                          boxes(),
                          bvh.keys[0].span(leaves()),
                          bvh.triangles[0].span(leaves()),
                          bvh.meeting.all(),
                          MortonKeys::axis_bits_for(leaves()),
                          branches(3 * MortonKeys::kMaxAxisBits + 1)};
    exec_.for_each("morton_keys", leaves(), keys);
    return keys.bits();
  }

  Exec& exec_;
  Searcher<Exec>& searcher_;
  const SceneCounts& counts_;
  SceneBuffers<Exec, Real>& scene_;
  double thickness_ = 0;
  bool is_ccd_ = true;
  int sorted_ = 0;  ///< which of the buffers holds the leaves in order
};

}  // namespace collided
