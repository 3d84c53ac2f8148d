#pragma once
// The stages of the linear bounding volume hierarchy (engines/lbvh/lbvh.hpp), from boxes to pairs.

#include <algorithm>
#include <bit>

#include "gpu/engines/broad_phase.hpp"
#include "gpu/engines/lbvh/lbvh.hpp"
#include "gpu/engines/lbvh/measure_worlds.hpp"

namespace collided {

/// The bounding volume hierarchy of one frame.
template <Executor Exec>
struct BvhBuffers {
  explicit BvhBuffers(Exec& exec, const char* part = "bvh")
      : keys{{exec, part}, {exec, part}},
        triangles{{exec, part}, {exec, part}},
        meeting(exec, part),
        nodes(exec, part),
        meshes(exec, part) {}

  void reserve(uint64_t leaves, bool keeps_meshes) {
    for (auto& buffer : keys) buffer.allocate(leaves);
    for (auto& buffer : triangles) buffer.allocate(leaves);
    meeting.allocate(leaves);
    nodes.allocate(2 * leaves - 2);
    if (keeps_meshes) meshes.allocate(2 * leaves - 2);
  }

  Buffer<uint64_t, Exec> keys[2];  ///< the second is room to sort in
  Buffer<uint32_t, Exec> triangles[2];
  Buffer<uint32_t, Exec> meeting;
  Buffer<BvhNode, Exec> nodes;
  Buffer<MeshesTogether, Exec> meshes;  ///< below each node, where rules keep most pairs apart
};

template <Executor Exec, class Real>
class LbvhPhase : public BroadPhaseDefaults {
 public:
  static constexpr Engine kEngine = Engine::kLbvh;
  static constexpr bool serves(Engine engine) { return engine == kEngine; }

  explicit LbvhPhase(const StepContext<Exec, Real>& context)
      : context_(context), exec_(context.exec), counts_(context.counts), scene_(context.scene), bvh_(context.exec) {}

  void begin(const StepPlan& step) { needs_ = step.needs; }
  void reserve() { bvh_.reserve(leaves(), keeps_meshes()); }

  /// How large the scene and its triangles are.
  void measure() {
    measure_bounds(exec_, context_.size());
    measure_extents(exec_, context_.size(), context_.prepare_narrow(needs_));
    if (has_worlds()) measure_worlds();
    scene_.leave_out_idle(exec_, leaves());
  }

  /// The leaves in order, and what is above them.
  void build() {
    exec_.stage("sort", [&] { sort(); });
    exec_.stage("hierarchy", [&] { join(); });
  }

  /// Hands what the walks of all leaves find to the sink. `is_first`: the search is the step's first.
  template <class Sink>
  void search(const char* name, const Sink& sink, uint64_t* next_item, bool is_first) {
    const BvhPairs source{bvh_.nodes.all(),     static_cast<uint32_t>(leaves()),
                          scene_.pair_filter(), is_first ? &context_.state()->leaves[LeafSum::kTests] : nullptr,
                          leaves_of_world(),    meshes_below()};
    context_.searcher.walk(name, leaves(), next_item, source, sink);
  }

  /// Nodes take the place of cells; nothing is registered.
  void finish(const StepState&, FrameCounts& counts) const {
    counts.cells = 2 * leaves() - max(counts_.worlds, 1u);
    counts.leaves = leaves();
  }

  bool holds_memory() const { return bvh_.nodes.capacity() > 0; }
  void release() { bvh_ = BvhBuffers<Exec>(exec_); }
  const BvhBuffers<Exec>& buffers() const { return bvh_; }

  // What build() consists of.

  void sort() {
    sorted_ = exec_.sort_pairs("sort_leaves", has_worlds() ? key_worlds() : key_all(),
                               {bvh_.keys[0].span(leaves()), bvh_.keys[1].span(leaves()),
                                bvh_.triangles[0].span(leaves()), bvh_.triangles[1].span(leaves())});
  }

  void join() {
    exec_.for_each("build_hierarchy", leaves(),
                   BuildHierarchy{{bvh_.keys[sorted_].all(), static_cast<uint32_t>(leaves()), leaves_of_world()},
                                  bvh_.triangles[sorted_].all(),
                                  boxes(),
                                  bvh_.meeting.all(),
                                  bvh_.nodes.all(),
                                  scene_.topology.filter(),
                                  meshes_below()});
  }

 private:
  uint64_t leaves() const { return counts_.triangles; }
  bool has_worlds() const { return counts_.worlds > 0; }
  /// 0: the scene is one.
  uint32_t leaves_of_world() const { return has_worlds() ? counts_.world_shape().triangles : 0; }
  Span<const Box<float>> boxes() const { return context_.boxes(); }
  bool keeps_meshes() const { return scene_.topology.branches > 0; }
  Span<MeshesTogether> meshes_below() const { return keeps_meshes() ? bvh_.meshes.all() : Span<MeshesTogether>{}; }
  /// `used`: bits of the keys without them. Where the branches need more than are left, all are in one.
  BvhBranches branches(int used) const {
    const uint32_t count = scene_.topology.branches;
    const int bits = count > 1 ? std::bit_width(count - 1) : 0;
    return {scene_.topology.filter(), bits <= std::min(BvhBranches::kMaxBits, 64 - used) ? bits : 0};
  }

  void measure_worlds() {
    WorldBuffers<Exec>& worlds = scene_.worlds;
    exec_.for_each_group("measure_worlds", {nullptr, counts_.worlds},
                         MeasureWorlds{boxes(), leaves_of_world(), needs_.settings.reach_of_any_pair(),
                                       worlds.bounds.data(), worlds.extents.data(), worlds.filters.data()});
  }
  /// The leaves' keys; returns their bits.
  int key_worlds() {
    const int axis_bits = WorldMortonKeys::axis_bits_for(leaves_of_world());
    const int bits = WorldMortonKeys::bits(axis_bits, counts_.worlds);
    const BvhBranches branches = this->branches(bits);
    exec_.for_each("morton_keys", leaves(),
                   WorldMortonKeys{scene_.worlds.bounds.data(), scene_.worlds.extents.data(), scene_.stepped_worlds(),
                                   boxes(), bvh_.keys[0].span(leaves()), bvh_.triangles[0].span(leaves()),
                                   bvh_.meeting.all(), axis_bits, branches});
    return bits + branches.bits;
  }
  int key_all() {
    const StepState* state = context_.state();
    const MortonKeys keys{&state->bounds,
                          {&state->bounds, &state->extents, leaves()},
                          boxes(),
                          bvh_.keys[0].span(leaves()),
                          bvh_.triangles[0].span(leaves()),
                          bvh_.meeting.all(),
                          MortonKeys::axis_bits_for(leaves()),
                          branches(3 * MortonKeys::kMaxAxisBits + 1)};
    exec_.for_each("morton_keys", leaves(), keys);
    return keys.bits();
  }

  const StepContext<Exec, Real>& context_;
  Exec& exec_;
  const SceneCounts& counts_;
  SceneBuffers<Exec, Real>& scene_;
  BvhBuffers<Exec> bvh_;
  LevelNeeds needs_;
  int sorted_ = 0;  ///< which of the buffers holds the leaves in order
};

}  // namespace collided
