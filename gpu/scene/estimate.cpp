// What a scene would hold and run, from the code of the step itself on a backend that computes nothing.

#include <algorithm>

#include "gpu/detector.hpp"
#include "gpu/positions/format.hpp"
#include "gpu/scene/rules.hpp"
#include "gpu/scene/shards/sharded_scene.hpp"
#include "gpu/search/dry_run.hpp"
#include "gpu/step/pipeline.hpp"
#include "gpu/tables/exclusions.hpp"

namespace collided {
namespace {

template <Backend backend, class Real>
class SceneDryRun {
 public:
  SceneDryRun(const SceneSpec& spec, uint64_t vertices, uint64_t triangles) : spec_(spec) {
    counts_.worlds = spec.worlds;
    counts_.vertices = vertices * count_worlds(spec), counts_.triangles = triangles * count_worlds(spec);
    counts_.triangle_offset.resize(spec.meshes.size() + 1);  // which triangles are a mesh's makes no difference
    reserve_tables();
    reserve_positions();
    if (!spec_.part_devices.empty()) scene_.share.take({});
  }

  /// Before the first step. Parts of a scene are alike.
  std::vector<MemoryPart> memory() const {
    std::vector<MemoryPart> all;
    for (size_t k = 0; k < spec_.part_devices.size(); ++k) add_memory(all, k, exec_.ledger().parts());
    return all.empty() ? exec_.ledger().parts() : all;
  }

  /// After the first frame.
  SceneEstimate run_frame() {
    Pipeline<DryRun<backend>, Real> pipeline(exec_, spec_, counts_, scene_);
    return exec_.frame([&] {
      exec_.stage("upload", [] {});
      if (excludes_rest_pairs(spec_)) exec_.stage("rest_pairs", [] {});
      SceneEstimate estimate;
      for (const StageTime& stage : pipeline.detect_contacts(true, settings_of(spec_, {}), 0).stages)
        estimate.stages.push_back(stage.stage);
      if (!spec_.part_devices.empty()) estimate.stages.push_back("merge");
      estimate.memory = memory();
      return estimate;
    });
  }

 private:
  /// As SceneDetector does. How many edges there are is not known.
  void reserve_tables() {
    ResidentTopology<DryRun<backend>>& tables = scene_.topology;
    tables.shape = counts_.world_shape();
    const uint64_t of_world = counts_.triangles / count_worlds(spec_);
    tables.triangles.allocate(of_world);
    tables.owned.allocate(counts_.triangles);
    if (have_edges(kinds_looked_for(spec_))) tables.triangle_edges.allocate(of_world);
    if (tells_features(spec_)) {
      tables.fan_begin.allocate(counts_.vertices / count_worlds(spec_) + 1);
      tables.fan_elements.allocate(3 * of_world);
    }
    if (needs_pair_filter(spec_)) {
      tables.mesh_of_triangle.allocate(of_world);
      tables.rules.allocate(spec_.meshes.size());
      tables.branches = count_branches(spec_);
      tables.idle = idle_meshes(spec_);
      tables.excluded_meshes.allocate(excluded_mesh_slots(spec_).size());
    }
    const bool is_thick = thickest_of(spec_) > 0;
    if (is_thick || tells_features(spec_)) tables.first_vertex.allocate(spec_.meshes.size());
    if (is_thick) tables.half_thickness.allocate(spec_.meshes.size());
    reserve_solids();
    scene_.reserve_boxes(counts_.triangles, counts_.vertices);
    if (spec_.worlds > 0) scene_.worlds.reserve(spec_.worlds);
  }
  /// Which triangles are of solids is not known. A closed mesh without holes has about twice as many as vertices.
  void reserve_solids() {
    if (!looks_into_solids(spec_) || !has_solids(spec_)) return;
    uint64_t of_solids = 0, solids = 0;
    for (const MeshSpec& mesh : spec_.meshes)
      if (mesh.solid) of_solids += mesh.vertex_count, ++solids;
    scene_.topology.solid_triangles.allocate(
        std::clamp(2 * of_solids, uint64_t{4}, max(counts_.triangles, uint64_t{4})));
    scene_.topology.solid_places.allocate(solids);
    scene_.topology.solid_vertices.allocate(counts_.vertices);
  }
  /// As ResidentPositions does for a frame with the positions at t = 1.
  void reserve_positions() {
    scene_.end.allocate(counts_.vertices);
    (spec_.mode == Mode::kDcd ? scene_.last_good : scene_.start).allocate(counts_.vertices);
    reserve_rigid();
  }
  /// As RigidMeshes does.
  void reserve_rigid() {
    uint64_t vertices = 0, bodies = 0;
    for (const MeshSpec& mesh : spec_.meshes)
      if (mesh.motion == MeshMotion::kRigid) vertices += mesh.vertex_count, ++bodies;
    if (bodies == 0) return;
    scene_.rigid.rest.allocate(vertices);
    scene_.rigid.bounds.allocate(bodies);
    if (spec_.mode == Mode::kDcd) return;
    scene_.rigid.first_vertex.allocate(spec_.meshes.size());
    scene_.rigid.deviations.allocate(spec_.meshes.size() + 1);
  }

  const SceneSpec& spec_;
  SceneCounts counts_;
  DryRun<backend> exec_;
  SceneBuffers<DryRun<backend>, Real> scene_{exec_};
};

/// What use() returns for the scene of a spec.
template <class Use>
auto with_dry_run(const SceneSpec& spec, uint64_t vertices, uint64_t triangles, const Use& use) {
  return with_real(spec.scalar, [&]<class Real>(Real) {
    if (device_of(spec).backend == Backend::kCuda)
      return use(SceneDryRun<Backend::kCuda, Real>(spec, vertices, triangles));
    return use(SceneDryRun<Backend::kCpu, Real>(spec, vertices, triangles));
  });
}

}  // namespace

uint64_t min_scene_bytes(const SceneSpec& spec, uint64_t vertices, uint64_t triangles) {
  const uint64_t topologies = std::max<size_t>(spec.part_devices.size(), 1);  // on the host
  uint64_t bytes = topologies * triangles * sizeof(std::array<uint32_t, 3>);
  const auto parts = with_dry_run(spec, vertices, triangles, [](const auto& scene) { return scene.memory(); });
  for (const MemoryPart& part : parts) bytes += part.bytes;
  return bytes;
}

SceneEstimate estimate_scene(const SceneSpec& spec, uint64_t vertices, uint64_t triangles) {
  check_spec(spec);
  check_exclusions(spec);
  if (vertices == 0 || triangles == 0)
    throw InvalidInput("meshes", "meshes have " + std::to_string(vertices) + " vertices and " +
                                     std::to_string(triangles) + " elements; at least one of each is needed");
  SceneEstimate estimate = with_dry_run(spec, vertices, triangles, [](auto&& scene) { return scene.run_frame(); });
  const LevelNeeds needs = needs_of(spec, settings_of(spec, {}));
  for_each_kind(
      [&](ContactKind kind, bool is_wanted, FieldSet& fields) {
        if (is_wanted && !needs.is_any_hit()) fields = needs.fields_of(kind);
      },
      spec.kinds, estimate.fields);
  return estimate;
}

}  // namespace collided
