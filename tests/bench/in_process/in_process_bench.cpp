// What a frame takes beyond the engine's work, of a daemon over gRPC and over shared memory and of an engine in this
// process. They take turns, frame by frame, so that other load on the machine affects all of them alike.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "client/app/daemon/own_daemon.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/cpp/client.hpp"
#include "client/in_process/local.hpp"
#include "client/measure/end_to_end/frames.hpp"
#include "client/measure/statistics.hpp"
#include "client/scenes/scene.hpp"

namespace {

using namespace collided;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string scene = "cloth_ball", backend = "auto";
  std::vector<double> scales{0.085, 0.47};
  int threads = 0, frames = 300, warm_up = 20;
};

struct Lane {
  std::string name;
  client::FrameStream stream;
  std::vector<double> whole_ms = {}, beside_ms = {};
};

class InProcessBench {
 public:
  explicit InProcessBench(const Options& options)
      : options_(options),
        daemon_({.backend = options.backend, .threads = options.threads, .tcp = true}),
        there_(client::Client::connect(daemon_.address())),
        here_(local({.backend = options.backend, .threads = options.threads})) {}

  Json run(double scale) {
    const auto scene = scenes::make_scene(options_.scene, scale);
    const v1::Scene made = create(there_, *scene), made_here = create(here_, *scene);
    std::vector<Lane> lanes;
    lanes.push_back({"grpc", there_.stream(made, {.local = {.use = client::Local::kOff}})});
    lanes.push_back({"shared_memory", there_.stream(create(there_, *scene), {.local = {.use = client::Local::kOn}})});
    lanes.push_back({"in_process", here_.stream(made_here)});
    for (int at = 0; at < options_.warm_up + options_.frames; ++at) {
      const v1::Frame frame = cli::frame_at(*scene, at, made.spec());
      const auto updates = cli::views_of(frame);
      for (size_t i = 0; i < lanes.size(); ++i)  // each in turn goes first, with cold caches
        send(lanes[(i + static_cast<size_t>(at)) % lanes.size()], frame.frame_id(), updates, at >= options_.warm_up);
    }
    return report(made, lanes);
  }

 private:
  static v1::Scene create(client::Client& client, const scenes::Scene& scene) {
    v1::SceneSpec spec;
    spec.set_mode(v1::DETECTION_MODE_CCD);
    spec.set_position_format(v1::POSITION_FORMAT_F32);
    return client.create_scene(spec, cli::mesh_inputs(scene.meshes()));
  }

  static void send(Lane& lane, uint64_t id, const std::vector<client::FrameUpdate>& updates, bool counts) {
    const auto start = Clock::now();
    lane.stream.send(id, updates);
    const client::FrameOutput output = lane.stream.receive();
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    output.check();
    if (!counts) return;
    lane.whole_ms.push_back(ms);
    lane.beside_ms.push_back(ms - output.done.metrics().engine_milliseconds());
  }

  Json report(const v1::Scene& made, std::vector<Lane>& lanes) const {
    Json json{{"device", made.device()},         {"scene", options_.scene},   {"triangles", made.triangle_count()},
              {"vertices", made.vertex_count()}, {"frames", options_.frames}, {"transports", Json::array()}};
    std::vector<double> shared;
    for (Lane& lane : lanes) {
      const double p50 = cli::quantile(lane.beside_ms, 0.5), p90 = cli::quantile(lane.beside_ms, 0.9);
      json["transports"].push_back({{"name", lane.name},
                                    {"whole_ms", cli::quantile(lane.whole_ms, 0.5)},
                                    {"beside_engine_ms", {{"p50", p50}, {"p90", p90}}}});
      if (lane.name == "shared_memory") shared = {p50, p90};
    }
    for (Json& lane : json["transports"]) {
      const Json& beside = lane["beside_engine_ms"];
      lane["ratio_to_shared_memory"] = {{"p50", beside["p50"].get<double>() / shared[0]},
                                        {"p90", beside["p90"].get<double>() / shared[1]}};
    }
    return json;
  }

  const Options options_;
  const cli::OwnDaemon daemon_;
  client::Client there_, here_;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"What a frame takes beyond the engine's work, over each transport: prints one JSON object"};
  app.add_option("--scene", options.scene, "Procedural scene")->capture_default_str();
  app.add_option("--scale", options.scales, "Refinements of the scene")->delimiter(',')->capture_default_str();
  app.add_option("--backend", options.backend, "cpu, cuda or auto")->capture_default_str();
  app.add_option("--threads", options.threads, "CPU threads (0: all cores)")->capture_default_str();
  app.add_option("--frames", options.frames, "Measured frames")->capture_default_str();
  app.add_option("--warm-up", options.warm_up, "Frames before these")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    InProcessBench bench(options);
    Json runs = Json::array();
    for (const double scale : options.scales) runs.push_back(bench.run(scale));
    std::printf("%s\n", Json{{"runs", runs}}.dump(1).c_str());
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "collided_in_process_bench: %s\n", e.what());
    return 1;
  }
}
