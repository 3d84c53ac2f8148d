// A resident scene: its plan, its detector, its worker, and what others may see of it.
#include "server/scenes/scene.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "server/errors.hpp"
#include "server/scenes/field_path.hpp"
#include "server/scenes/frame_check.hpp"

namespace collided::server {

Scene::Scene(std::string id, ScenePlan plan, size_t queue_capacity)
    : id_(std::move(id)), plan_(std::move(plan)), pending_(plan_.engine), worker_(queue_capacity) {
  for (size_t i = 0; i < plan_.meshes.size(); ++i) {
    shown_.vertices += pending_.meshes[i].vertex_count;
    shown_.triangles += pending_.meshes[i].triangles.size() + plan_.meshes[i].awaited;
    awaited_.push_back(plan_.meshes[i].awaited);
    uploading_.push_back(false);
    plan_.engine.meshes[i].triangles = {};
  }
}

SceneSnapshot Scene::snapshot() const {
  std::lock_guard lock(mutex_);
  return shown_;
}

uint64_t Scene::awaited(uint32_t mesh) const {
  std::lock_guard lock(mutex_);
  return awaited_.at(mesh);
}

void Scene::begin_upload(uint32_t mesh) {
  std::lock_guard lock(mutex_);
  if (awaited_[mesh] == 0)
    throw FailedPrecondition(
        "mesh", fmt::format("mesh is {} (\"{}\"), which awaits no triangles", mesh, plan_.meshes[mesh].name));
  if (uploading_[mesh])
    throw FailedPrecondition(
        "mesh", fmt::format("mesh is {} (\"{}\"), which another upload brings", mesh, plan_.meshes[mesh].name));
  uploading_[mesh] = true;
}

void Scene::end_upload(uint32_t mesh) {
  std::lock_guard lock(mutex_);
  uploading_[mesh] = false;
}

bool Scene::awaits_triangles() const {
  return std::any_of(awaited_.begin(), awaited_.end(), [](uint64_t n) { return n > 0; });
}

bool Scene::unusable() const {
  std::lock_guard lock(mutex_);
  return !shown_.ready && !awaits_triangles();
}

void Scene::check_open() const {
  if (closed_) throw NotFound("scene_id", fmt::format("scene {} was deleted", id_));
}

void Scene::build_if_complete() {
  check_open();
  if (awaits_triangles()) return;  // this thread alone writes what it reads
  try {
    detector_ = Detector::create(std::move(pending_));
  } catch (const InvalidInput& e) {
    throw with_path(e, spec_path);
  } catch (const ResourceExhausted& e) {
    throw_if_budget(e);
    throw;
  }
  pending_ = {};
  publish();
}

void Scene::add_triangles(uint32_t mesh, const Triangles& triangles) {
  check_open();
  const uint64_t wanted = awaited(mesh);
  if (wanted == 0)
    throw FailedPrecondition(
        "mesh", fmt::format("mesh is {} (\"{}\"), which awaits no triangles", mesh, plan_.meshes[mesh].name));
  if (triangles.size() != wanted)
    throw InvalidInput("triangles", fmt::format("triangles is incomplete: the upload ended after {} of {} triangles",
                                                triangles.size(), wanted));
  auto& all = pending_.meshes[mesh].triangles;
  all.insert(all.end(), triangles.begin(), triangles.end());  // may throw, so the mesh counts as complete only after
  {
    std::lock_guard lock(mutex_);
    awaited_[mesh] = 0;
  }
  build_if_complete();
}

FrameResult Scene::apply(uint64_t frame_id, const FrameInput& frame) {
  check_open();
  if (!detector_) throw FailedPrecondition("scene_id", fmt::format("scene {} still awaits triangles", id_));
  const uint64_t last = shown_.last_frame_id;  // written by this thread only
  check_frame_id(frame_id, last);
  check_updates(plan_, frame, last == 0);
  FrameResult result;
  try {
    result = detector_->detect(frame);
  } catch (const InvalidInput& e) {
    throw with_path(e, frame_path);
  } catch (const ResourceExhausted& e) {
    throw_if_budget(e);
    throw;
  }
  {
    std::lock_guard lock(mutex_);
    shown_.last_frame_id = frame_id;
  }
  publish();
  return result;
}

void Scene::publish() {
  auto memory = detector_->memory();
  const auto& topology = detector_->topology();
  auto device = detector_->device().name;
  std::lock_guard lock(mutex_);
  shown_.ready = true;
  shown_.device = std::move(device);
  shown_.edges = topology.edges.size();
  shown_.memory = std::move(memory);
}

}  // namespace collided::server
