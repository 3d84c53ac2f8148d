// The triangles of a scene that has yet to be built: those that have come, and how many are awaited.
#include "server/scenes/scene/uploads.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "server/errors.hpp"

namespace collided::server {
namespace {

uint64_t element_bytes(const SceneSpec& spec) {
  uint64_t bytes = 0;
  for (const auto& mesh : spec.meshes)
    bytes += mesh.triangles.capacity() * sizeof(mesh.triangles[0]) + mesh.edges.capacity() * sizeof(mesh.edges[0]) +
             mesh.points.capacity() * sizeof(mesh.points[0]);
  return bytes;
}

bool is_awaited(uint64_t triangles) { return triangles > 0; }

[[noreturn]] void throw_complete(uint32_t mesh, const std::string& name) {
  throw FailedPrecondition("mesh", fmt::format("mesh is {} (\"{}\"), which awaits no triangles", mesh, name));
}

}  // namespace

void ReceivedTriangles::move_to(std::vector<TriangleCorners>& mesh, MemoryHold& held) {
  mesh.reserve(mesh.size() + triangles_.size());
  for (; !triangles_.empty(); triangles_.pop_front()) mesh.push_back(triangles_.front());
  held.absorb(held_);
}

SceneUploads::SceneUploads(const SceneRecord& record, SceneSpec spec, const SceneQuota& quota)
    : record_(record), held_(quota.whole), pending_(std::move(spec)) {
  const auto plan = record.plan();
  held_.resize(plan_bytes(*plan) + element_bytes(pending_));
  pending_.memory_quota = quota.of_engine;
  for (const MeshPlan& mesh : plan->meshes) awaited_.push_back(mesh.awaited);
  uploading_.resize(awaited_.size(), false);
}

uint64_t SceneUploads::awaited(uint32_t mesh) const {
  const std::lock_guard lock(mutex_);
  return awaited_.at(mesh);
}

bool SceneUploads::awaits_any() const {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(awaited_, is_awaited);
}

void SceneUploads::throw_awaits(const std::string& field) const {
  const auto plan = record_.plan();
  const std::lock_guard lock(mutex_);
  const auto first = std::ranges::find_if(awaited_, is_awaited);
  if (first == awaited_.end())
    throw FailedPrecondition(field,
                             fmt::format("{}: scene {} has all its triangles and is being built", field, record_.id()));
  const auto mesh = static_cast<size_t>(first - awaited_.begin());
  const auto others = std::ranges::count_if(awaited_, is_awaited) - 1;
  throw FailedPrecondition(
      field, fmt::format("{}: scene {} takes no frames yet: mesh {} (\"{}\") awaits {} of its {} triangles{}; send "
                         "them with UploadMesh",
                         field, record_.id(), mesh, plan->meshes[mesh].name, *first, plan->meshes[mesh].triangles,
                         others > 0 ? fmt::format(", and {} more meshes await theirs", others) : ""));
}

void SceneUploads::begin(uint32_t mesh) {
  const std::string name = record_.plan()->meshes[mesh].name;
  const std::lock_guard lock(mutex_);
  if (awaited_[mesh] == 0) throw_complete(mesh, name);
  if (uploading_[mesh])
    throw FailedPrecondition("mesh", fmt::format("mesh is {} (\"{}\"), which another upload is sending", mesh, name));
  uploading_[mesh] = true;
}

void SceneUploads::end(uint32_t mesh) {
  const std::lock_guard lock(mutex_);
  uploading_[mesh] = false;
}

void SceneUploads::add(uint32_t mesh, ReceivedTriangles& triangles) {
  record_.check_open();
  const uint64_t wanted = awaited(mesh);
  if (wanted == 0) throw_complete(mesh, record_.plan()->meshes[mesh].name);
  if (triangles.size() != wanted)
    throw InvalidInput("triangles",
                       fmt::format("triangles is incomplete: the upload ended after {} of {} triangles, in {}",
                                   triangles.size(), wanted, record_.mesh_name(mesh)));
  triangles.move_to(pending_.meshes[mesh].triangles, held_);  // may throw, so the mesh is complete only afterwards
  const std::lock_guard lock(mutex_);
  awaited_[mesh] = 0;
}

SceneSpec SceneUploads::take_spec(MemoryHold& held) {
  held.absorb(held_);
  return std::exchange(pending_, {});
}

void SceneUploads::set_mesh_count(size_t meshes) {
  const std::lock_guard lock(mutex_);
  awaited_.resize(meshes, 0);
  uploading_.resize(meshes, false);
}

void SceneUploads::release() {
  pending_ = {};
  held_.resize(0);
}

}  // namespace collided::server
