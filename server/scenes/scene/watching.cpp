// The watchers of a scene's frames.
#include "server/scenes/scene/watching.hpp"

#include <utility>

namespace collided::server {

void SceneWatchers::add(std::shared_ptr<SceneWatcher> watcher) {
  const std::lock_guard lock(mutex_);
  watchers_.push_back(std::move(watcher));
  size_ = watchers_.size();
}

void SceneWatchers::remove(const SceneWatcher& watcher) {
  List removed;  // may hold the last reference, which is dropped without the lock
  const std::lock_guard lock(mutex_);
  const auto is_it = [&](const auto& other) { return other.get() == &watcher; };
  for (const auto& other : watchers_)
    if (is_it(other)) removed.push_back(other);
  std::erase_if(watchers_, is_it);
  size_ = watchers_.size();
}

SceneWatchers::List SceneWatchers::all() const {
  if (size() == 0) return {};
  const std::lock_guard lock(mutex_);
  return watchers_;
}

}  // namespace collided::server
