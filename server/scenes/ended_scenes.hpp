#pragma once
// Recently ended scenes, remembered so that their clients learn why they ended. No gRPC here.

#include <cstddef>
#include <deque>
#include <map>
#include <string>

#include "server/scenes/scene/record.hpp"

namespace collided::server {

/// Not thread-safe.
class EndedScenes {
 public:
  static constexpr size_t kMaxPerClient = 1024;

  /// Forgets the client's oldest one beyond kMaxPerClient.
  void add(const std::string& client, std::string id, SceneEnd end);
  /// Null for a scene that this client never had or that has been forgotten.
  const SceneEnd* find(const std::string& client, const std::string& id) const;

 private:
  struct Entry {
    std::string id;
    SceneEnd end;
  };
  std::map<std::string, std::deque<Entry>> clients_;
};

}  // namespace collided::server
