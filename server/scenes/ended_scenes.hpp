#pragma once
// Scenes that have ended, remembered for a while so that their clients are told why. No gRPC here.

#include <chrono>
#include <cstddef>
#include <deque>
#include <map>
#include <string>

namespace collided::server {

/// How a scene ended.
struct SceneEnd {
  bool is_expired = false;  ///< otherwise it was deleted
  double lease_seconds = 0;
  std::chrono::steady_clock::time_point when{};

  /// Such as "was deleted"; `now` tells how long ago.
  std::string text(std::chrono::steady_clock::time_point now) const;
};

/// Not thread-safe.
class EndedScenes {
 public:
  static constexpr size_t kMaxPerClient = 1024;

  /// Forgets the client's oldest scene if it has too many.
  void add(const std::string& client, std::string id, SceneEnd end);
  /// Null for a scene that this client never had or that is forgotten.
  const SceneEnd* find(const std::string& client, const std::string& id) const;

 private:
  struct Entry {
    std::string id;
    SceneEnd end;
  };
  std::map<std::string, std::deque<Entry>> clients_;
};

}  // namespace collided::server
