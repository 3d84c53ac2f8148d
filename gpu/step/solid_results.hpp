#pragma once
// What a frame tells of solids: vertices in them, how meshes lie to each other, signed distances.

#include "gpu/step/results.hpp"
#include "gpu/step/signed_distances.hpp"
#include "gpu/step/solid_phase.hpp"
#include "gpu/step/touching_meshes.hpp"

namespace collided {

template <Executor Exec, class Real>
class SolidResults {
 public:
  SolidResults(Exec& exec, const SceneSpec& spec, SceneBuffers<Exec, Real>& scene, Results<Exec, Real>& results)
      : exec_(exec), spec_(spec), scene_(scene), results_(results), phase_(exec, spec, scene) {}

  void release() { phase_.release(); }

  /// Finds what there is, once all other contacts are on the host, and gives these their signs.
  void look(const LevelNeeds& needs, FrameResult& result) {
    inside_ = {};
    if (needs.is_any_hit() && result.any_contact) return;
    const uint64_t count = phase_.find(needs, result.counts);
    if (spec_.kinds.vertex_solid) {
      result.counts.contacts.vertex_solid = count;
      result.any_contact = result.any_contact || count > 0;
    }
    if (needs.is_any_hit()) return;
    exec_.stage("solids", [&] {
      if (count > 0) inside_ = results_.bring_inside(phase_.columns(), count);
      if (!scene_.topology.solids.topology) return;
      const FoundInSolids found{scene_.topology.solids, results_.crossings(), results_.ties(), inside_, phase_.on()};
      if (needs.tells_states) find_states(found, result);
      if (needs.tells_signed) sign_distances(exec_.host_loops(), found, result);
    });
  }
  /// Adds the vertices in solids to the other contacts, when these are in their places.
  void tell(FrameResult& result) {
    if (!spec_.kinds.vertex_solid) return;
    result.vertex_solid = inside_;
    ContactSet& first = result.first.vertex_solid = inside_;
    for_each_field([&](ContactField, auto& column) { column.truncate(results_.first_on_host()); }, first);
  }

 private:
  void find_states(const FoundInSolids& found, FrameResult& result) {
    const exact::PollScope poll([&] { exec_.asks().ask(); });
    result.pair_states = find_pair_states(found, [&](uint32_t first, uint32_t second) {
      ++result.counts.exact_decisions;
      return overlap(first, second);
    });
  }
  /// Of meshes that only touch.
  bool overlap(uint32_t first, uint32_t second) {
    const std::vector<bool>& are_solid = scene_.topology.solids.are_solid;
    const SolidMeshes& meshes = scene_.topology.solids;
    MemoryHold held(spec_.memory_quota);
    const auto read = [&](uint32_t vertex, uint32_t count) {
      std::vector<Vec3<Real>> positions(count);
      held.resize(held.bytes() + count * (sizeof(Vec3<Real>) + sizeof(Vec3<double>)));
      exec_.download(positions.data(), scene_.end.data() + vertex, count * sizeof(positions[0]));
      std::vector<Vec3<double>> points(count);
      std::transform(positions.begin(), positions.end(), points.begin(),
                     [](const Vec3<Real>& p) { return convert<double>(p); });
      return points;
    };
    const MeshOnHost a(meshes, first, read), b(meshes, second, read);
    if (are_solid[first] && are_solid[second]) return have_common_volume(a.solid(), b.solid());
    return triangles_go_through(meshes, results_.ties(), first, second, a, b);
  }

  Exec& exec_;
  const SceneSpec& spec_;
  SceneBuffers<Exec, Real>& scene_;
  Results<Exec, Real>& results_;
  SolidPhase<Exec, Real> phase_;
  ContactSet inside_;
};

}  // namespace collided
