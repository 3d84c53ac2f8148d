// All resident scenes by id.
#include "server/scenes/scene_store.hpp"

#include <spdlog/fmt/fmt.h>

#include <random>
#include <utility>

#include "server/errors.hpp"
#include "server/shorten.hpp"

namespace collided::server {
namespace {

// 128 random bits: an id is never met twice, and none can be guessed from another.
std::string random_id() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) id += fmt::format("{:08x}", static_cast<uint32_t>(random()));
  return id;
}

[[noreturn]] void throw_not_found(const std::string& id) {
  throw NotFound("scene_id", fmt::format("scene_id is \"{}\", which is no scene here", shorten(id, 64)));
}

}  // namespace

std::shared_ptr<Scene> SceneStore::add(ScenePlan plan) {
  auto scene = std::make_shared<Scene>(random_id(), std::move(plan), queue_capacity_);  // copies much: not locked yet
  std::lock_guard lock(mutex_);
  if (scenes_.size() >= max_scenes_)
    throw LimitExceeded("spec", fmt::format("{} scenes exist, and the limit is {}", scenes_.size(), max_scenes_));
  scenes_.emplace(scene->id(), scene);
  return scene;
}

std::shared_ptr<Scene> SceneStore::find(const std::string& id) const {
  std::lock_guard lock(mutex_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) throw_not_found(id);
  return found->second;
}

std::shared_ptr<Scene> SceneStore::remove(const std::string& id) {
  std::lock_guard lock(mutex_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) throw_not_found(id);
  auto scene = std::move(found->second);
  scenes_.erase(found);
  scene->close();
  return scene;
}

std::vector<std::shared_ptr<Scene>> SceneStore::page(const std::string& after, size_t count) const {
  std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<Scene>> page;
  for (auto it = scenes_.upper_bound(after); it != scenes_.end() && page.size() < count; ++it)
    page.push_back(it->second);
  return page;
}

void SceneStore::clear() {
  std::map<std::string, std::shared_ptr<Scene>> scenes;
  {
    std::lock_guard lock(mutex_);
    scenes.swap(scenes_);
  }
  for (auto& [id, scene] : scenes) scene->close();
  for (auto& [id, scene] : scenes) scene->worker().flush();
}

}  // namespace collided::server
