// All resident scenes by id.
#include "server/scenes/scene_store.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "server/auth/secrets.hpp"
#include "server/errors.hpp"
#include "server/shorten.hpp"

namespace collided::server {
namespace {

std::string scene_id(const std::string& daemon) { return daemon.empty() ? random_id() : daemon + "." + random_id(); }

}  // namespace

SceneStore::Added SceneStore::add(const Client& owner, SceneRequest request) {
  SceneIdentity identity{
      scene_id(context_.name), random_id(), request.request_id, request.fingerprint, owner, request.lease_seconds, 0};
  {
    const std::lock_guard lock(mutex_);
    if (SceneUse before = repeated_locked(owner, request)) return {std::move(before), false};
    check_limits_locked(owner);
    identity.queue_capacity = queue_capacity_;
  }
  place(request.plan);
  // Expensive, hence not under the lock; the checks are repeated afterwards.
  auto scene = std::make_shared<Scene>(std::move(identity), std::move(request.plan), context_);
  const std::lock_guard lock(mutex_);
  if (SceneUse before = repeated_locked(owner, request)) return {std::move(before), false};
  check_limits_locked(owner);
  scene->worker().set_capacity(queue_capacity_);  // which may have changed meanwhile
  SceneUse use(scene);
  scenes_.emplace(scene->id(), scene);
  if (!request.request_id.empty()) requests_.emplace(RequestKey{owner->name, request.request_id}, scene);
  return {std::move(use), true};
}

void SceneStore::place(ScenePlan& plan) const {
  Placement placed = context_.devices.place(wish_of(plan));
  plan.engine.device = placed.device;
  if (placed.threads > 0) plan.engine.threads = placed.threads;
  plan.quota = std::move(placed.quota);
  plan.shards = std::move(placed.shards);
}

SceneUse SceneStore::repeated_locked(const Client& owner, const SceneRequest& request) const {
  if (request.request_id.empty()) return {};
  const auto found = requests_.find({owner->name, request.request_id});
  if (found == requests_.end()) return {};
  if (found->second->identity().fingerprint != request.fingerprint)
    throw AlreadyExists("request_id",
                        fmt::format("request_id is \"{}\", which created scene {} from a different request",
                                    shorten(request.request_id, 64), found->second->id()));
  return SceneUse(found->second);
}

void SceneStore::check_limits_locked(const Client& owner) const {
  if (scenes_.size() >= max_scenes_)
    throw LimitExceeded::quota(
        "daemon", fmt::format("max_scenes is {}, and {} scenes exist on this daemon", max_scenes_, scenes_.size()));
  const auto own = static_cast<size_t>(std::count_if(scenes_.begin(), scenes_.end(), [&](const auto& entry) {
    return entry.second->identity().owner->name == owner->name;
  }));
  if (own >= owner->limits.max_scenes)
    throw LimitExceeded::quota("client:" + owner->name,
                               fmt::format("max_scenes_per_client is {}, and client \"{}\" has {} scenes",
                                           owner->limits.max_scenes, owner->name, own));
}

SceneStore::Scenes::const_iterator SceneStore::find_locked(const Client& owner, const std::string& id) const {
  const auto found = scenes_.find(id);
  if (found == scenes_.end() || found->second->identity().owner->name != owner->name) throw_not_found_locked(owner, id);
  return found;
}

void SceneStore::throw_not_found_locked(const Client& owner, const std::string& id) const {
  const SceneEnd* end = ended_.find(owner->name, id);
  const std::string why = end ? end->text(std::chrono::steady_clock::now()) : "does not exist";
  throw NotFound("scene_id", fmt::format("scene_id is \"{}\", which {}", shorten(id, 64), why));
}

SceneUse SceneStore::find(const Client& owner, const std::string& id) const {
  const std::lock_guard lock(mutex_);
  return SceneUse(find_locked(owner, id)->second);
}

void SceneStore::note_removed_locked(const std::shared_ptr<Scene>& scene) {
  std::erase_if(removed_, [](const auto& removed) { return removed.expired(); });
  removed_.push_back(scene);
}

std::shared_ptr<Scene> SceneStore::take_out_locked(Scenes::const_iterator found, const SceneEnd& end) {
  auto scene = found->second;
  ended_.add(scene->identity().owner->name, scene->id(), end);
  scenes_.erase(found);
  requests_.erase({scene->identity().owner->name, scene->identity().request_id});
  note_removed_locked(scene);
  return scene;
}

std::shared_ptr<Scene> SceneStore::remove(const Client& owner, const std::string& id) {
  const SceneEnd end{.when = std::chrono::steady_clock::now()};
  std::shared_ptr<Scene> scene;
  {
    const std::lock_guard lock(mutex_);
    scene = take_out_locked(find_locked(owner, id), end);
  }
  scene->record().close(end);
  return scene;
}

std::vector<std::shared_ptr<Scene>> SceneStore::page(const Client& owner, const std::string& after,
                                                     size_t count) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<Scene>> page;
  for (auto it = scenes_.upper_bound(after); it != scenes_.end() && page.size() < count; ++it)
    if (it->second->identity().owner->name == owner->name) page.push_back(it->second);
  return page;
}

std::vector<std::shared_ptr<Scene>> SceneStore::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<Scene>> scenes;
  for (const auto& [id, scene] : scenes_) scenes.push_back(scene);
  return scenes;
}

std::vector<std::shared_ptr<Scene>> SceneStore::remove_expired(std::chrono::steady_clock::time_point now) {
  const auto end_of = [&](const Scene& scene) { return SceneEnd{true, scene.identity().lease_seconds, now}; };
  std::vector<std::shared_ptr<Scene>> expired;
  {
    const std::lock_guard lock(mutex_);
    for (auto it = scenes_.cbegin(); it != scenes_.cend();)
      if (const auto here = it++; here->second->is_expired(now))
        expired.push_back(take_out_locked(here, end_of(*here->second)));
  }
  for (const auto& scene : expired) {
    scene->record().close(end_of(*scene));
    scene->worker().post([scene] { scene->release(); });
  }
  return expired;
}

void SceneStore::set_max_scenes(size_t max_scenes) {
  const std::lock_guard lock(mutex_);
  max_scenes_ = max_scenes;
}

void SceneStore::set_queue_capacity(size_t queue_capacity) {
  const std::lock_guard lock(mutex_);
  queue_capacity_ = queue_capacity;
  for (const auto& [id, scene] : scenes_) scene->worker().set_capacity(queue_capacity);
}

void SceneStore::clear() {
  Scenes scenes;
  std::vector<std::weak_ptr<Scene>> removed;
  {
    const std::lock_guard lock(mutex_);
    scenes.swap(scenes_);
    removed.swap(removed_);
    requests_.clear();
  }
  for (auto& [id, scene] : scenes) scene->record().close({.when = std::chrono::steady_clock::now()});
  for (auto& [id, scene] : scenes) scene->worker().flush();
  for (const auto& weak : removed)
    if (const auto scene = weak.lock()) scene->worker().flush();
}

}  // namespace collided::server
