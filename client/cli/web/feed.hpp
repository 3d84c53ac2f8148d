#pragma once
// Watches a scene and shows its frames on the page, whatever becomes of the scene and its daemon.

#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "client/cli/web/messages.hpp"
#include "client/cli/web/page_server.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

struct FeedOptions {
  std::string scene_id;  ///< empty: whatever scene there is, one after the other
  double max_frames_per_second = 30;
  uint32_t max_contacts_per_kind = 4096;
};

/// The scene that there is; empty if there is none. Throws UsageError naming them if there are several.
std::string only_scene(client::Client& client);

class Feed {
 public:
  /// Both outlive the feed.
  Feed(client::Client& client, PageServer& page, FeedOptions options);
  /// Until the scene ends, if the options name one, or until it is told to stop.
  void run(const std::stop_token& stop);

 private:
  std::string find_scene();
  ShownScene look_at(const std::string& scene_id);
  void show_frames(const std::string& scene_id, const std::stop_token& stop);
  void wait_before_retry(const std::stop_token& stop);
  bool may_go_on(const client::Error& error);

  client::Client& client_;
  PageServer& page_;
  const FeedOptions options_;
  uint32_t epoch_ = 0;
  std::mutex mutex_;  // guards the watcher against being cancelled as it goes
  std::condition_variable_any stopped_;
  std::optional<client::Watcher> watcher_;
};

}  // namespace collided::cli
