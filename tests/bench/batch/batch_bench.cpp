// Many small scenes, one frame each: as a set, in one call and over streams, and in a call each as scenes of their own.
// These take turns, so that other load on the machine affects all of them alike, and must find the same number of
// contacts.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/app/daemon/own_daemon.hpp"
#include "client/cpp/batch/scene_set.hpp"
#include "client/cpp/transport/grpc/channel.hpp"
#include "client/measure/statistics.hpp"
#include "collided/v1/collision_service.grpc.pb.h"

namespace {

using namespace collided;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
using Triangles = std::vector<std::array<uint32_t, 3>>;

struct Options {
  std::string backend = "auto", accuracy = "CERTIFIED", commit;
  uint32_t worlds = 1000, side = 15;
  int threads = 0, rounds = 20, warm_up = 3;
  bool sets_only = false;
};

constexpr uint32_t kFloorSide = 5;

Triangles grid(uint32_t side) {
  Triangles triangles;
  const uint32_t row = side + 1;
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      const uint32_t a = y * row + x;
      triangles.insert(triangles.end(), {{a, a + 1, a + row}, {a + 1, a + row + 1, a + row}});
    }
  return triangles;
}

void add_grid(std::vector<float>& out, uint32_t side, double phase, double height) {
  for (uint32_t y = 0; y <= side; ++y)
    for (uint32_t x = 0; x <= side; ++x) {
      const double u = double(x) / side, v = double(y) / side;
      const double wave = height * (1 + 2 * std::sin(7 * u + phase) * std::sin(5 * v + 0.7 * phase));
      out.insert(out.end(), {static_cast<float>(u), static_cast<float>(v), static_cast<float>(wave)});
    }
}

/// A cloth that waves into a floor. Each world waves in its own way.
std::vector<float> cloth(const Options& options, uint32_t world, int frame) {
  std::vector<float> out;
  add_grid(out, options.side, 0.1 * frame + world, 0.02);
  return out;
}
std::vector<float> ground() {
  std::vector<float> out;
  add_grid(out, kFloorSide, 0, 0);
  return out;
}

std::string bytes_of(const std::vector<float>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(float)};
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  char date[11];
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
  return date;
}

/// A way for frames to go.
struct Lane {
  std::string name;
  client::SceneSet set;
  bool is_call = false, is_in_place = false;
  std::vector<double> ms = {}, engine = {}, decode = {}, encode = {};
};

class BatchBench {
 public:
  explicit BatchBench(const Options& options)
      : options_(options),
        daemon_({.backend = options.backend, .threads = options.threads, .tcp = true, .streams = options.worlds + 16}),
        client_(client::Client::connect(daemon_.address())),
        stub_(v1::CollisionService::NewStub(client_.channels().connect())) {
    lanes_.push_back({"one_call", make_set(client::Local::kOff), true});
    lanes_.push_back({"grpc_stream", make_set(client::Local::kOff)});
    lanes_.push_back({"shared_memory", make_set(client::Local::kOn)});
    lanes_.push_back({"shared_memory_in_place", make_set(client::Local::kOn), false, true});
    for (uint32_t world = 0; world < options.worlds && !options.sets_only; ++world)
      scenes_.push_back(client_.create_scene(spec(), meshes()).scene_id());
  }

  Json run() {
    std::vector<double> calls, calls_engine;
    uint64_t contacts = 0;
    for (int frame = 0; frame < options_.warm_up + options_.rounds; ++frame) {
      const std::vector<float> positions = positions_at(frame);
      std::vector<uint64_t> found;
      for (size_t i = 0; i < lanes_.size(); ++i)  // each in turn goes first, with cold caches
        found.push_back(ask(lanes_[(i + static_cast<size_t>(frame)) % lanes_.size()], frame, positions));
      if (!options_.sets_only) {
        const Turn alone = ask_alone(frame);
        found.push_back(alone.contacts);
        if (counts(frame)) calls.push_back(alone.ms), calls_engine.push_back(alone.engine_ms);
      }
      contacts = found[0];
      for (const uint64_t other : found)
        if (other != contacts)
          throw std::runtime_error("frame " + std::to_string(frame) + " has " + std::to_string(contacts) +
                                   " contacts one way and " + std::to_string(other) + " another way");
    }
    const v1::Scene& scene = lanes_[0].set.scene();
    Json json{{"date", today()},
              {"commit", options_.commit},
              {"device", scene.device()},
              {"worlds", options_.worlds},
              {"triangles", scene.triangle_count()},
              {"vertices", scene.vertex_count()},
              {"accuracy", options_.accuracy},
              {"rounds", options_.rounds},
              {"contacts", contacts}};
    for (Lane& lane : lanes_) {
      Json& of_lane = json[lane.name + "_ms"] = times(lane.ms, lane.engine);
      of_lane["decode_p50"] = cli::quantile(lane.decode, 0.5);
      of_lane["encode_p50"] = cli::quantile(lane.encode, 0.5);
    }
    if (options_.sets_only) return json;
    json["a_call_each_ms"] = times(calls, calls_engine);
    json["ratio"] = cli::quantile(calls, 0.5) / cli::quantile(lanes_[0].ms, 0.5);
    return json;
  }

 private:
  struct Turn {
    double ms = 0, engine_ms = 0;
    uint64_t contacts = 0;
  };

  bool counts(int frame) const { return frame >= options_.warm_up; }

  client::SceneSet make_set(client::Local use) {
    return client::SceneSet::create(client_, spec(), meshes(), options_.worlds,
                                    {.local = {.use = use, .output_bytes = uint64_t{64} << 20}});
  }

  v1::SceneSpec spec() const {
    v1::SceneSpec spec;
    spec.set_mode(v1::DETECTION_MODE_CCD);
    spec.set_position_format(v1::POSITION_FORMAT_F32);
    v1::Accuracy accuracy;
    if (!v1::Accuracy_Parse("ACCURACY_" + options_.accuracy, &accuracy))
      throw std::runtime_error("--accuracy is '" + options_.accuracy + "', no level");
    spec.set_accuracy(accuracy);
    return spec;
  }
  std::array<client::MeshInput, 2> meshes() const {
    return {
        {{.name = "floor", .vertex_count = (kFloorSide + 1) * (kFloorSide + 1), .triangles = floor_, .is_static = true},
         {.name = "cloth", .vertex_count = (options_.side + 1) * (options_.side + 1), .triangles = cloth_}}};
  }

  std::vector<float> positions_at(int frame) const {
    std::vector<float> positions;
    for (uint32_t world = 0; world < options_.worlds; ++world) {
      if (frame == 0) add_grid(positions, kFloorSide, 0, 0);
      const std::vector<float> of_world = cloth(options_, world, frame);
      positions.insert(positions.end(), of_world.begin(), of_world.end());
    }
    return positions;
  }

  /// Number of contacts.
  uint64_t ask(Lane& lane, int frame, const std::vector<float>& positions) {
    client::SetUpdate update{.positions = std::as_bytes(std::span(positions))};
    if (lane.is_in_place) {
      const std::span<std::byte> room = lane.set.input(update.positions.size());
      std::memcpy(room.data(), update.positions.data(), room.size());
      update.positions = room;
    }
    const client::SetStep step{&lane.set, update};
    const auto begin = Clock::now();
    const client::SetOutput output =
        lane.is_call ? std::move(client::detect_batch({&step, 1})[0]) : lane.set.detect(update);
    const std::chrono::duration<double, std::milli> ms = Clock::now() - begin;
    output.check();
    if (counts(frame)) {
      lane.ms.push_back(ms.count());
      lane.engine.push_back(output.done.metrics().engine_milliseconds());
      lane.decode.push_back(output.done.metrics().decode_milliseconds());
      lane.encode.push_back(output.done.metrics().encode_milliseconds());
    }
    return output.vertex_triangle.count + output.edge_edge.count + output.triangle_triangle.count;
  }
  Turn ask_alone(int frame) {
    std::vector<v1::DetectFrameRequest> requests(options_.worlds);
    for (uint32_t world = 0; world < options_.worlds; ++world) {
      requests[world].set_scene_id(scenes_[world]);
      requests[world].mutable_frame()->set_frame_id(static_cast<uint64_t>(frame) + 1);
      if (frame == 0) requests[world].mutable_frame()->add_updates()->set_positions(bytes_of(ground()));
      v1::MeshUpdate& update = *requests[world].mutable_frame()->add_updates();
      update.set_mesh(1);
      update.set_positions(bytes_of(cloth(options_, world, frame)));
    }
    Turn turn;
    const auto begin = Clock::now();
    for (const v1::DetectFrameRequest& request : requests) {
      v1::DetectFrameResponse response;
      client::check(stub_->DetectFrame(client_.channels().call_context(request.scene_id()).get(), request, &response));
      turn.contacts += response.done().contact_count();
      turn.engine_ms += response.done().metrics().engine_milliseconds();
    }
    turn.ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    return turn;
  }
  static Json times(std::vector<double>& ms, std::vector<double>& engine) {
    std::vector<double> beside;
    for (size_t i = 0; i < ms.size(); ++i) beside.push_back(ms[i] - engine[i]);
    return {{"p50", cli::quantile(ms, 0.5)},
            {"p99", cli::quantile(ms, 0.99)},
            {"engine_p50", cli::quantile(engine, 0.5)},
            {"beside_p50", cli::quantile(beside, 0.5)}};
  }

  const Options options_;
  const Triangles floor_ = grid(kFloorSide), cloth_ = grid(options_.side);
  const cli::OwnDaemon daemon_;
  client::Client client_;
  const std::unique_ptr<v1::CollisionService::Stub> stub_;
  std::vector<Lane> lanes_;
  std::vector<std::string> scenes_;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Many small scenes, one frame each, as a set and in a call each: prints one JSON object"};
  app.add_option("--worlds", options.worlds, "Scenes")->check(CLI::Range(1, 65536))->capture_default_str();
  app.add_option("--side", options.side, "Cells of a cloth's side: 2 * side^2 triangles, and 50 of the floor")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--accuracy", options.accuracy, "Level, such as FAST")->capture_default_str();
  app.add_option("--backend", options.backend, "cpu, cuda or auto")->capture_default_str();
  app.add_option("--threads", options.threads, "CPU threads (0: all cores)")->capture_default_str();
  app.add_option("--rounds", options.rounds, "Frames of each scene that are timed")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--warm-up", options.warm_up, "Frames before them")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_flag("--sets-only", options.sets_only, "No calls for scenes of their own");
  app.add_option("--commit", options.commit, "For the record");
  CLI11_PARSE(app, argc, argv);
  try {
    std::printf("%s\n", BatchBench(options).run().dump(1).c_str());
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "collided_batch_bench: %s\n", e.what());
    return 1;
  }
}
