// Recently ended scenes.
#include "server/scenes/ended_scenes.hpp"

#include <algorithm>
#include <utility>

namespace collided::server {

void EndedScenes::add(const std::string& client, std::string id, SceneEnd end) {
  auto& entries = clients_[client];
  entries.push_back({std::move(id), end});
  if (entries.size() > kMaxPerClient) entries.pop_front();
}

const SceneEnd* EndedScenes::find(const std::string& client, const std::string& id) const {
  const auto found = clients_.find(client);
  if (found == clients_.end()) return nullptr;
  const auto& entries = found->second;
  const auto entry = std::find_if(entries.rbegin(), entries.rend(), [&](const Entry& other) { return other.id == id; });
  return entry == entries.rend() ? nullptr : &entry->end;
}

}  // namespace collided::server
