#pragma once
// A local server in this process, with a scene, and streams to it.

#include <dirent.h>

#include <filesystem>
#include <memory>
#include <string>

#include "server/auth/authenticator.hpp"
#include "server/convert/scene.hpp"
#include "server/frames/observer.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/transport/local/local_server.hpp"
#include "tests/integration/local/local_stream.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::server {

using test::LocalStream;
using test::Memory;
using test::RawLocal;

class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-local-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline size_t open_files() {
  size_t count = 0;
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

/// Waits until it holds; false after 30 s.
template <class Condition>
bool eventually(const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

class Serving {
 public:
  explicit Serving(LocalTimeouts timeouts = {}, const Config& config = cpu_config())
      : config_(config), authenticator_(config_), observer_(metrics_, lifecycle_), host_(config_, observer_) {
    LocalOptions options;
    options.path = folder_.file("local");
    options.timeouts = timeouts;
    options.cuda_ipc = config_.cuda_ipc;
    server_ = std::make_unique<LocalServer>(options, host_, authenticator_, metrics_);
  }
  ~Serving() {
    server_.reset();
    host_.scenes().clear();
  }

  static Config cpu_config() {
    Config config;
    config.backend = "cpu";
    config.threads = 1;
    return config;
  }
  std::string make_scene(const pb::CreateSceneRequest& request = test::tip_request()) {
    SceneDefaults defaults;
    defaults.backend = "cpu";
    defaults.threads = 1;
    const auto added = host_.scenes().add(client(), parse_scene(request, defaults));
    added.scene->worker().post([scene = added.scene] { scene->engine().build_if_complete(); });
    added.scene->worker().flush();
    return added.scene->id();
  }
  SceneUse scene(const std::string& id) { return host_.scenes().find(client(), id); }
  Client client() const { return authenticator_.identify("", ""); }
  SceneHost& host() { return host_; }
  LocalServer& server() { return *server_; }
  const Authenticator& authenticator() const { return authenticator_; }
  Metrics& metrics() { return metrics_; }
  std::string path() const { return folder_.file("local"); }

 private:
  Folder folder_;
  const Config config_;
  Metrics metrics_;
  Lifecycle lifecycle_;
  Authenticator authenticator_;
  ServiceObserver observer_;
  SceneHost host_;
  std::unique_ptr<LocalServer> server_;
};

}  // namespace collided::server
