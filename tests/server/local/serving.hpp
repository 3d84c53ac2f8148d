#pragma once
// A local server in this process, with a scene, and streams to it.

#include <dirent.h>

#include <filesystem>
#include <memory>
#include <string>

#include "server/auth/authenticator.hpp"
#include "server/local/local_server.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/service/observer.hpp"
#include "tests/integration/local_socket.hpp"
#include "tests/integration/tip_scene.hpp"

namespace collided::server {

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
  explicit Serving(LocalPatience patience = {}, const Config& config = cpu_config())
      : config_(config), authenticator_(config_), observer_(metrics_, lifecycle_), host_(config_, observer_) {
    LocalOptions options;
    options.path = folder_.file("local");
    options.patience = patience;
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
    added.scene->worker().post([scene = added.scene] { scene->build_if_complete(); });
    added.scene->worker().flush();
    return added.scene->id();
  }
  SceneUse scene(const std::string& id) { return host_.scenes().find(client(), id); }
  Client client() const { return authenticator_.identify("", ""); }
  SceneHost& host() { return host_; }
  LocalServer& server() { return *server_; }
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

/// An opened stream with memory for small frames.
class LocalStream {
 public:
  static constexpr size_t kInput = 256 << 10;

  LocalStream(const std::string& path, const std::string& scene_id, size_t output = 64 << 10, uint32_t window = 0)
      : memory_(kInput + output), raw_(path) {
    raw_.send(test::open_request(scene_id, kInput, output, window), {memory_.file()});
    const auto response = raw_.receive();
    if (response && response->frame().has_opened()) opened_ = response->frame().opened();
  }

  const std::optional<pb::StreamOpened>& opened() const { return opened_; }
  const Memory& memory() const { return memory_; }
  RawLocal& raw() { return raw_; }
  /// With the arrays of its contacts in the chunks.
  test::Answer receive(uint64_t frame_id) {
    test::Answer answer;
    while (const auto packet = raw_.receive()) {
      if (packet->has_closed()) break;
      const auto& response = packet->frame();
      EXPECT_EQ(response.frame_id(), frame_id);
      if (response.has_contacts()) take(response.contacts(), answer);
      for (const auto& chunk : response.done().contacts()) take(chunk, answer);
      if (response.has_done()) answer.done = response.done();
      if (response.has_error()) answer.error = response.error();
      if (response.has_done() || response.has_error()) return answer;
    }
    answer.ended = true;
    return answer;
  }
  test::Answer ask(const pb::Frame& frame) {
    raw_.send(frame);
    return receive(frame.frame_id());
  }
  /// With its positions in shared memory.
  test::Answer ask_shared(const pb::Frame& frame) { return ask(test::shared_frame(frame, memory_)); }
  /// Chunks whose arrays came in shared memory.
  size_t shared_chunks() const { return shared_chunks_; }

 private:
  void take(const pb::ContactChunk& chunk, test::Answer& answer) {
    answer.chunks.push_back(test::own_arrays(chunk, memory_, kInput));
    shared_chunks_ += chunk.has_shared();
  }

  Memory memory_;
  RawLocal raw_;
  std::optional<pb::StreamOpened> opened_;
  size_t shared_chunks_ = 0;
};

}  // namespace collided::server
