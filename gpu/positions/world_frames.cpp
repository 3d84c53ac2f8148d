#include "gpu/positions/world_frames.hpp"

namespace collided {
namespace {

/// The meshes that a frame has of one world, by their numbers in it.
std::vector<SentMesh> in_world(std::vector<SentMesh> meshes, uint32_t meshes_of_world) {
  for (SentMesh& sent : meshes) sent.mesh %= meshes_of_world;
  return meshes;
}

}  // namespace

WorldFrames::WorldFrames(const SceneSpec& spec, const std::vector<SentMesh>& meshes, const FirstMeshes& first,
                         Asks& asks)
    : frame_(spec.worlds, 0) {
  const auto of_world = static_cast<uint32_t>(spec.meshes.size());
  std::vector<std::vector<SentMesh>> to_check(spec.worlds);  // empty for most
  const bool has_static = std::any_of(spec.meshes.begin(), spec.meshes.end(),
                                      [](const MeshSpec& mesh) { return mesh.motion != MeshMotion::kDeformable; });
  for (const SentMesh& sent : meshes) {
    const uint32_t world = sent.mesh / of_world;
    const bool is_first = first[uint64_t{world} * of_world];
    frame_[world] = static_cast<uint8_t>(kStepsWorld | (is_first ? kIsFirstOfWorld : 0));
    if (is_first || has_static) to_check[world].push_back(sent);
  }
  for (uint32_t world = 0; world < spec.worlds; ++world) {
    if (to_check[world].empty()) continue;
    asks.ask_if_due();
    unless_refused(world, [&] {
      const auto begin = first.begin() + static_cast<std::ptrdiff_t>(uint64_t{world} * of_world);
      check_turn(spec, in_world(std::move(to_check[world]), of_world), FirstMeshes(begin, begin + of_world));
    });
  }
}

std::vector<RefusedWorld> WorldFrames::refused() && {
  std::vector<RefusedWorld> refused = std::move(refused_);
  std::stable_sort(refused.begin(), refused.end(),
                   [](const RefusedWorld& a, const RefusedWorld& b) { return a.world < b.world; });
  const auto is_same = [](const RefusedWorld& a, const RefusedWorld& b) { return a.world == b.world; };
  refused.erase(std::unique(refused.begin(), refused.end(), is_same), refused.end());
  return refused;
}

}  // namespace collided
