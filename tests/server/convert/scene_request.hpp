#pragma once
// Requests for a scene of two triangles, and what they become.

#include <array>
#include <functional>
#include <limits>
#include <string>

#include "server/convert/scene.hpp"

namespace collided::server {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

template <size_t N>
std::string packed(const std::array<uint32_t, N>& vertices) {
  return {reinterpret_cast<const char*>(vertices.data()), sizeof(vertices)};
}
inline std::string triangle(std::array<uint32_t, 3> corners) { return packed(corners); }

inline pb::CreateSceneRequest request() {
  pb::CreateSceneRequest request;
  auto* spec = request.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_CCD);
  auto* mesh = spec->add_meshes();
  mesh->set_name("cloth");
  mesh->set_vertex_count(4);
  mesh->set_triangles(triangle({0, 1, 2}) + triangle({0, 2, 3}));
  return request;
}

inline pb::CreateSceneRequest request_with(const std::function<void(pb::SceneSpec&)>& change) {
  auto wanted = request();
  change(*wanted.mutable_spec());
  return wanted;
}

inline SceneSpec scene_with(const std::function<void(pb::SceneSpec&)>& change) {
  return parse_scene(request_with(change), {}).plan.engine;
}

constexpr std::pair<pb::BroadPhaseEngine, Engine> kEngines[] = {
    {pb::BROAD_PHASE_ENGINE_UNSPECIFIED, Engine::kAuto},
    {pb::BROAD_PHASE_ENGINE_OCTREE, Engine::kOctree},
    {pb::BROAD_PHASE_ENGINE_TOP_DOWN_OCTREE, Engine::kTopDown},
    {pb::BROAD_PHASE_ENGINE_BOTTOM_UP_OCTREE, Engine::kBottomUp},
    {pb::BROAD_PHASE_ENGINE_UNIFORM_GRID, Engine::kUniformGrid},
    {pb::BROAD_PHASE_ENGINE_TWO_LEVEL_GRID, Engine::kTwoLevelGrid},
    {pb::BROAD_PHASE_ENGINE_LBVH, Engine::kLbvh},
    {pb::BROAD_PHASE_ENGINE_VSS, Engine::kVss},
    {pb::BROAD_PHASE_ENGINE_ALL_PAIRS, Engine::kAllPairs}};

}  // namespace collided::server
