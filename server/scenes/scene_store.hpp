#pragma once
// All resident scenes by id. Safe from any thread. No gRPC here.

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/scenes/scene.hpp"

namespace collided::server {

class SceneStore {
 public:
  SceneStore(size_t max_scenes, size_t queue_capacity) : max_scenes_(max_scenes), queue_capacity_(queue_capacity) {}

  /// Throws LimitExceeded.
  std::shared_ptr<Scene> add(ScenePlan plan);
  /// Throws NotFound.
  std::shared_ptr<Scene> find(const std::string& id) const;
  /// Takes a scene out and closes it; frames in its queue are answered with NotFound. Throws NotFound.
  std::shared_ptr<Scene> remove(const std::string& id);
  /// At most `count` scenes in the order of their ids, from the first id after `after`.
  std::vector<std::shared_ptr<Scene>> page(const std::string& after, size_t count) const;
  /// Removes all scenes and waits for the work that they have in hand.
  void clear();

 private:
  const size_t max_scenes_, queue_capacity_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Scene>> scenes_;
};

}  // namespace collided::server
