// What watchers cost the simulator: whole frames of one stream, in blocks with and without watchers in turn, so that
// other load on the machine affects both alike. One of the watchers is stopped: it never reads.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <vector>

#include "client/app/daemon/own_daemon.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/cpp/client.hpp"
#include "client/measure/end_to_end/frames.hpp"
#include "client/measure/statistics.hpp"
#include "client/scenes/scene.hpp"

namespace {

using namespace collided;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string scene = "cloth_ball", backend = "auto";
  double scale = 1, rate = 0;
  int threads = 0, watchers = 4, blocks = 20, frames = 100;
};

client::WatchOptions everything(const scenes::Scene& scene, double rate) {
  client::WatchOptions options{.max_frames_per_second = rate, .max_contacts_per_kind = 1000};
  for (uint32_t mesh = 0; mesh < scene.meshes().size(); ++mesh) options.meshes.push_back(mesh);
  return options;
}

/// Watchers on threads of their own, the first of which never reads.
class Watchers {
 public:
  Watchers(client::Client& client, const std::string& scene_id, const client::WatchOptions& options, int count) {
    for (int i = 0; i < count; ++i) watchers_.push_back(client.watch(scene_id, options));
    for (size_t i = 1; i < watchers_.size(); ++i) threads_.emplace_back([this, i] { read(watchers_[i]); });
  }
  ~Watchers() {
    for (client::Watcher& watcher : watchers_) watcher.cancel();
  }

 private:
  static void read(client::Watcher& watcher) try {
    for (;;) watcher.receive();
  } catch (const client::Error&) {  // cancelled
  }

  std::vector<client::Watcher> watchers_;
  std::vector<std::jthread> threads_;
};

class WatchBench {
 public:
  explicit WatchBench(const Options& options)
      : options_(options),
        daemon_({.backend = options.backend, .threads = options.threads}),
        client_(client::Client::connect(daemon_.address())),
        scene_(scenes::make_scene(options.scene, options.scale)),
        made_(client_.create_scene(spec(), cli::mesh_inputs(scene_->meshes()))),
        stream_(client_.stream(made_, {.local = {.use = client::Local::kOff}})) {}

  Json run() {
    std::vector<double> warm_up, alone, watched;
    send_block(warm_up);
    for (int block = 0; block < options_.blocks; ++block) {
      send_block(alone);
      const Watchers watchers(client_, made_.scene_id(), everything(*scene_, options_.rate), options_.watchers);
      send_block(watched);
    }
    const Json without = times(alone), with = times(watched);
    return {{"device", made_.device()},
            {"scene", options_.scene},
            {"scale", options_.scale},
            {"triangles", made_.triangle_count()},
            {"vertices", made_.vertex_count()},
            {"watchers", options_.watchers},
            {"stopped", options_.watchers > 0 ? 1 : 0},
            {"max_frames_per_second", options_.rate},
            {"frames", alone.size()},
            {"alone_ms", without},
            {"watched_ms", with},
            {"ratio", {{"p50", ratio(with, without, "p50")}, {"p99", ratio(with, without, "p99")}}}};
  }

 private:
  static v1::SceneSpec spec() {
    v1::SceneSpec spec;
    spec.set_mode(v1::DETECTION_MODE_CCD);
    spec.set_position_format(v1::POSITION_FORMAT_F32);
    return spec;
  }
  void send_block(std::vector<double>& ms) {
    for (int i = 0; i < options_.frames; ++i) {
      const v1::Frame frame = cli::frame_at(*scene_, sent_++, made_.spec());
      const auto start = Clock::now();
      stream_.send(frame);
      stream_.receive().check();
      ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    }
  }
  static Json times(std::vector<double>& ms) {
    return {{"p50", cli::quantile(ms, 0.5)}, {"p99", cli::quantile(ms, 0.99)}, {"max", cli::quantile(ms, 1)}};
  }
  static double ratio(const Json& with, const Json& without, const char* name) {
    return with.at(name).get<double>() / without.at(name).get<double>();
  }

  const Options options_;
  const cli::OwnDaemon daemon_;
  client::Client client_;
  const std::unique_ptr<scenes::Scene> scene_;
  const v1::Scene made_;
  client::FrameStream stream_;
  int sent_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"What watchers cost the simulator's frames: prints one JSON object"};
  app.add_option("--scene", options.scene, "Procedural scene")->capture_default_str();
  app.add_option("--scale", options.scale, "Refinement of the scene")->capture_default_str();
  app.add_option("--backend", options.backend, "cpu, cuda or auto")->capture_default_str();
  app.add_option("--threads", options.threads, "CPU threads (0: all cores)")->capture_default_str();
  app.add_option("--watchers", options.watchers, "Watchers, the first of which never reads")->capture_default_str();
  app.add_option("--rate", options.rate, "Frames a second that each asks for (0: all)")->capture_default_str();
  app.add_option("--blocks", options.blocks, "Blocks of each kind")->capture_default_str();
  app.add_option("--frames", options.frames, "Frames in a block")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    std::printf("%s\n", WatchBench(options).run().dump(1).c_str());
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "collided_watch_bench: %s\n", e.what());
    return 1;
  }
}
