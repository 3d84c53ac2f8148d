#pragma once
// All resident scenes by id, with their owners and leases. Safe from any thread. No gRPC here.

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/scenes/ended_scenes.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

/// A checked request for a scene.
struct SceneRequest {
  ScenePlan plan;
  std::string request_id;     ///< chosen by the client; may be empty
  uint64_t fingerprint = 0;   ///< equal for equal requests
  double lease_seconds = 30;  ///< > 0
};

class SceneStore {
 public:
  SceneStore(size_t max_scenes, size_t queue_capacity, SceneContext context)
      : context_(std::move(context)), max_scenes_(max_scenes), queue_capacity_(queue_capacity) {}

  struct Added {
    SceneUse scene;
    bool is_new = true;  ///< false: an earlier request with the same id created it
  };
  /// Throws LimitExceeded, AlreadyExists.
  Added add(const Client& owner, SceneRequest request);
  /// Throws NotFound, also for another client's scene; for a recently ended scene of this client it says how it ended.
  SceneUse find(const Client& owner, const std::string& id) const;
  /// Removes and closes a scene; queued frames are answered with NotFound. Throws NotFound.
  std::shared_ptr<Scene> remove(const Client& owner, const std::string& id);
  /// At most `count` scenes of a client, ordered by id, starting after `after`.
  std::vector<std::shared_ptr<Scene>> page(const Client& owner, const std::string& after, size_t count) const;
  std::vector<std::shared_ptr<Scene>> all() const;
  /// Removes and closes the scenes whose lease has run out, and frees their memory once their workers are done.
  std::vector<std::shared_ptr<Scene>> remove_expired(std::chrono::steady_clock::time_point now);
  void set_max_scenes(size_t max_scenes);
  /// Maximum number of unary frames that wait for a scene; applies to existing scenes, too.
  void set_queue_capacity(size_t queue_capacity);
  /// Removes all scenes and waits for their running work, including that of scenes removed earlier.
  void clear();

 private:
  using Scenes = std::map<std::string, std::shared_ptr<Scene>>;
  using RequestKey = std::pair<std::string, std::string>;  // client, request id

  void place(ScenePlan& plan) const;
  // `_locked`: the caller holds mutex_.
  SceneUse repeated_locked(const Client& owner, const SceneRequest& request) const;
  void check_limits_locked(const Client& owner) const;
  Scenes::const_iterator find_locked(const Client& owner, const std::string& id) const;
  [[noreturn]] void throw_not_found_locked(const Client& owner, const std::string& id) const;
  void note_removed_locked(const std::shared_ptr<Scene>& scene);
  std::shared_ptr<Scene> take_out_locked(Scenes::const_iterator found, const SceneEnd& end);

  const SceneContext context_;
  mutable std::mutex mutex_;  // guards what follows
  size_t max_scenes_;
  size_t queue_capacity_;
  Scenes scenes_;
  std::map<RequestKey, std::shared_ptr<Scene>> requests_;
  std::vector<std::weak_ptr<Scene>> removed_;  // whose workers may still have jobs
  EndedScenes ended_;
};

}  // namespace collided::server
