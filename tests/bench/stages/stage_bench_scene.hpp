#pragma once
// One step of a scene (CCD, CERTIFIED, F32, octree) in the engine's own buffers, with the input of each stage from the
// previous one, so that stages can be measured one by one on real data.

#include <string>
#include <utility>
#include <vector>

#include "gpu/exec/cpu/cpu_exec.hpp"
#include "gpu/search/cpu/searcher.hpp"
#include "gpu/step/pipeline.hpp"
#include "gpu/tables/topology.hpp"
#include "tests/support/case.hpp"

namespace collided::test {

/// The inputs of the narrow phase's steps, for one kind of features.
struct QueryLists {
  std::vector<uint64_t> candidates;  ///< their boxes overlap
  std::vector<uint64_t> kept;        ///< by the coplanarity filter
  std::vector<uint64_t> screened;    ///< no fixed direction keeps them apart
  std::vector<ResumableQuery> near;  ///< nor can float tell them apart
};

class StageScene {
 public:
  StageScene(const std::string& name, const Case& step);

  uint64_t triangles() const { return features.topology.triangles.size(); }
  StepState& state() const { return *buffers.state.data(); }
  VertexTriangle kind_of(const VertexTriangle*) const { return {buffers.topology.triangles.all()}; }
  EdgeEdge kind_of(const EdgeEdge*) const { return {buffers.topology.edges.all()}; }
  template <class Kind>
  Kind kind() const {
    return kind_of(static_cast<const Kind*>(nullptr));
  }
  template <class Kind>
  const QueryLists& lists() const {
    return lists_[kIndexOf<Kind>];
  }

  SceneSpec spec;
  double thickness_at_rest;  ///< of tests of the positions at t = 1; the step itself has none
  FeatureTables features;
  SceneCounts counts{features.topology};
  Frame frame;
  CpuExec exec{1, 0};  ///< one thread: figures are those of one core
  SceneBuffers<CpuExec, float> buffers{exec};
  Searcher<CpuExec> searcher{exec};
  StepContext<CpuExec, float> context{exec, searcher, spec, counts, buffers};
  BoxPhase<CpuExec, float> boxes{context};
  OctreePhase<CpuExec, float> octree{context};
  LbvhPhase<CpuExec, float> hierarchy{context};
  StepPlan plan;                                     ///< of the step
  StepState step{};                                  ///< as the step left it
  std::vector<std::pair<uint32_t, uint32_t>> pairs;  ///< of triangles whose boxes overlap

 private:
  void make_resident(const Case& step);
  void run_step();
  void build_octree();
  void find_pairs();
  template <class Kind>
  void find_queries(QueryLists& lists) const;

  QueryLists lists_[2];
};

}  // namespace collided::test
