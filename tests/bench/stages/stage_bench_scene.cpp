#include "tests/bench/stages/stage_bench_scene.hpp"

#include <algorithm>

#include "tests/bench/stages/stage_bench_functors.hpp"

namespace collided::test {
namespace {

/// Steps after which the octree's levels have settled.
constexpr int kSteps = 6;

template <class T, class U>
void send(Buffer<T, CpuExec>& to, const std::vector<U>& from) {
  static_assert(sizeof(T) == sizeof(U));
  to.allocate(from.size());
  std::copy_n(reinterpret_cast<const std::byte*>(from.data()), from.size() * sizeof(T),
              reinterpret_cast<std::byte*>(to.data()));
}

std::vector<Vec3<float>> all_positions(const std::vector<Positions>& meshes) {
  std::vector<Vec3<float>> out;
  for (const Positions& mesh : meshes)
    for (const Vec3d& p : mesh)
      out.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  return out;
}

/// A sink that keeps the pairs, as they are found.
struct ListPairs {
  static constexpr bool kTakesPairs = true;
  std::vector<std::pair<uint32_t, uint32_t>>* pairs;

  bool is_over() const { return false; }
};
class PairLister {
 public:
  explicit PairLister(const ListPairs& sink) : pairs_(*sink.pairs) {}
  void prefetch(uint32_t) const {}
  void take(uint32_t a, uint32_t b) { pairs_.emplace_back(a, b); }
  void finish() const {}

 private:
  std::vector<std::pair<uint32_t, uint32_t>>& pairs_;
};

SceneSpec spec_of(const Case& step) {
  SceneSpec settings;
  settings.engine = Engine::kOctree;
  return spec_for(step, settings);
}

}  // namespace
}  // namespace collided::test

template <>
struct collided::TakerOf<collided::test::ListPairs> {
  using Type = collided::test::PairLister;
};

namespace collided::test {

StageScene::StageScene(const std::string& name, const Case& step)
    : spec(spec_of(step)),
      thickness_at_rest(dcd_thickness(name)),
      features([&] {
        Asks asks;
        return make_features(spec.meshes, asks);
      }()),
      frame(step, spec.mode, spec.scalar) {
  make_resident(step);
  run_step();
  find_pairs();
  Found<uint64_t> vertex_triangle(this->step.candidates[0]), edge_edge(this->step.candidates[1]);
  const auto sink = feature_sink(*this, KeepAll{}, vertex_triangle, edge_edge);
  take_pairs(*this, sink, feature_boxes(*this, sink));
  lists_[kIndexOf<VertexTriangle>].candidates = vertex_triangle.take();
  lists_[kIndexOf<EdgeEdge>].candidates = edge_edge.take();
  find_queries<VertexTriangle>(lists_[kIndexOf<VertexTriangle>]);
  find_queries<EdgeEdge>(lists_[kIndexOf<EdgeEdge>]);
}

/// As the engine does once for a scene, and for the positions of a frame.
void StageScene::make_resident(const Case& step) {
  ResidentTopology<CpuExec>& resident = buffers.topology;
  send(resident.triangles, features.topology.triangles);
  send(resident.triangle_edges, features.triangle_edges);
  send(resident.edges, features.topology.edges);
  send(resident.owned, features.owned);
  const auto is_static = [](const MeshSpec& m) { return m.motion == MeshMotion::kStatic; };
  if (std::any_of(spec.meshes.begin(), spec.meshes.end(), is_static)) {
    std::vector<MeshRule> rules;
    for (const MeshSpec& m : spec.meshes)
      rules.push_back({m.groups, m.collide_mask, is_static(m) ? 1u : 0u, m.self_contacts ? 1u : 0u});
    send(resident.mesh_of_triangle, meshes_of_elements(features.topology));
    send(resident.rules, rules);
  }
  buffers.reserve_boxes(triangles(), features.topology.vertex_count);
  send(buffers.start, all_positions(step.start));
  send(buffers.end, all_positions(step.end));
}

void StageScene::run_step() {
  Pipeline<CpuExec, float> pipeline(exec, spec, features.topology, buffers);
  for (int i = 0; i < kSteps; ++i) {
    exec.begin_frame();
    pipeline.detect_contacts(true, settings_of(spec, {}), 0);
  }
  step = state();
  plan.needs = needs_of(spec, settings_of(spec, {}));
  boxes.begin(plan.needs);
  boxes.box_triangles(true);
  for (int i = 0; i < kSteps; ++i) build_octree();
  hierarchy.begin(plan);
  hierarchy.reserve();
  hierarchy.measure();
}

/// As the pipeline does in a step.
void StageScene::build_octree() {
  do {
    octree.plan(plan);
    octree.begin(plan);
    octree.reserve();
    state() = {};
    octree.clear();
    octree.measure();
    octree.build();
  } while (octree.grow(state()) || octree.must_refine(state()));
  FrameCounts counts_of_step;
  octree.finish(state(), counts_of_step);
}

void StageScene::find_pairs() {
  pairs.reserve(step.pairs);
  octree.search("list_pairs", ListPairs{&pairs}, state().next_item, true);
}

template <class Kind>
void StageScene::find_queries(QueryLists& lists) const {
  const MaybeCoplanar<float> keep = coplanarity_filter(*this);
  for (const uint64_t key : lists.candidates)
    if (keep(kind<Kind>(), points_of_key<Kind>(*this, key))) lists.kept.push_back(key);
  Found<uint64_t> screened(lists.kept.size());
  run_all(lists.kept.size(), screen<Kind>(*this, lists.kept, screened));
  lists.screened = screened.take();
  Found<ResumableQuery> near(lists.screened.size());
  run_all(lists.screened.size(), approach<Kind>(*this, lists.screened, near));
  lists.near = near.take();
}

}  // namespace collided::test
