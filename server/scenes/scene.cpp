// A resident scene: its record and lease, its uploads, its engine and its worker.
#include "server/scenes/scene.hpp"

#include <utility>

namespace collided::server {

Scene::Scene(SceneIdentity identity, ScenePlan plan, SceneContext context)
    : context_(std::move(context)),
      quota_(plan),
      record_(std::move(identity), without_elements(plan)),
      lease_(record_.identity().lease_seconds, context_.now),
      uploads_(record_, std::move(plan.engine), quota_),
      engine_(record_, uploads_, quota_, context_.devices),
      worker_(record_.identity().queue_capacity) {}

SceneSnapshot Scene::snapshot() const {
  SceneSnapshot now = record_.snapshot();
  if (!now.ready) now.memory = {{"host", quota_.whole->held()}};  // includes what uploads have received so far
  return now;
}

std::shared_ptr<SceneStream> Scene::begin_stream(const std::shared_ptr<SceneStream>& stream, const std::string& token) {
  record_.check_open();
  if (!record_.is_ready()) uploads_.throw_awaits("open.scene_id");
  return record_.begin_stream(stream, token);
}

void Scene::add_triangles(uint32_t mesh, ReceivedTriangles& triangles) {
  uploads_.add(mesh, triangles);
  engine_.build_if_complete();
}

void Scene::release() {
  engine_.release();
  uploads_.release();
}

}  // namespace collided::server
