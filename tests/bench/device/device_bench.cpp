// Whole frames of a simulator on the daemon's GPU: positions in device memory, contacts in device memory, beside the
// same frames with contacts, or both, in shared memory of the host. All take turns frame by frame.

#include <cuda_runtime.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/app/daemon/own_daemon.hpp"
#include "client/cpp/client.hpp"
#include "client/measure/statistics.hpp"
#include "tests/bench/inputs.hpp"

namespace {

using namespace collided;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string scene = "cloth_ball_92_93";
  double scale = 1;
  int frames = 300, warm_up = 50;
  uint64_t output_mb = 64;
};

void check(cudaError_t error) {
  if (error != cudaSuccess) throw std::runtime_error(std::string("the client's device: ") + cudaGetErrorString(error));
}

/// Where arrays begin.
constexpr uint64_t aligned(uint64_t bytes) { return (bytes + 63) / 64 * 64; }

class DeviceMemory {
 public:
  explicit DeviceMemory(uint64_t bytes) { check(cudaMalloc(&memory_, bytes)); }
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;
  ~DeviceMemory() { cudaFree(memory_); }

  std::string handle() const {
    cudaIpcMemHandle_t handle;
    check(cudaIpcGetMemHandle(&handle, memory_));
    return {reinterpret_cast<const char*>(&handle), sizeof(handle)};
  }
  void write(uint64_t offset, const std::vector<std::byte>& bytes) const {
    check(cudaMemcpy(static_cast<char*>(memory_) + offset, bytes.data(), bytes.size(), cudaMemcpyHostToDevice));
    check(cudaDeviceSynchronize());
  }

 private:
  void* memory_ = nullptr;
};

/// Where a lane's positions and contacts are, how its client waits, and whether it uses the GPU itself between frames,
/// which then changes from one process to the other.
struct LaneKind {
  const char* name;
  bool device_in, device_out, polls, writes;
};
constexpr LaneKind kLanes[] = {{"device to device", true, true, false, true},
                               {"device to device, client polls", true, true, true, true},
                               {"device to device, client polls, leaves the GPU alone", true, true, true, false},
                               {"device to host", true, false, false, true},
                               {"host to host", false, false, false, false}};

struct FrameTime {
  double latency, step, engine, decode, encode, queue;
};

class Lane {
 public:
  Lane(const LaneKind& kind, client::Client& client, const v1::Scene& scene, const Options& options, uint64_t bytes_in)
      : kind_(kind),
        memory_((options.output_mb << 20) + 2 * bytes_in),
        bytes_in_(bytes_in),
        contacts_(options.output_mb << 20),
        stream_(client.stream(scene, {.window = 1,
                                      .local = {.use = client::Local::kOn,
                                                .output_bytes = contacts_,
                                                .cuda_ipc_handle = kind.device_in ? memory_.handle() : "",
                                                .output_cuda_ipc_handle = kind.device_out ? memory_.handle() : ""}})) {}

  const LaneKind& kind() const { return kind_; }
  /// Of the frames that count.
  const std::vector<FrameTime>& times() const { return times_; }
  Json stages() const {
    Json out;
    for (const auto& [name, ms] : stages_) out[name] = cli::median(ms);
    return out;
  }

  /// Sends whole positions of each mesh and waits for the answer; returns the number of contacts. Those of frames that
  /// count, and of the others, have places of their own.
  uint64_t run(const std::vector<test::Positions>& meshes, bool counts) {
    v1::Frame frame;
    frame.set_frame_id(++id_);
    std::vector<client::FrameUpdate> updates;
    uint64_t at = contacts_ + (counts ? bytes_in_ : 0);
    for (uint32_t mesh = 0; mesh < meshes.size(); ++mesh) {
      const std::vector<std::byte> bytes = test::pack(meshes[mesh], Scalar::kF32);
      kind_.device_in ? add_on_device(mesh, bytes, at, frame) : add_on_host(mesh, bytes, updates);
    }
    const auto start = Clock::now();
    kind_.device_in ? stream_.send(frame) : stream_.send(id_, updates);
    const client::FrameOutput output = receive();
    const double latency = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    output.check();
    if (counts) keep(latency, output.done.metrics());
    return output.done.contact_count();
  }

 private:
  void add_on_device(uint32_t mesh, const std::vector<std::byte>& bytes, uint64_t& at, v1::Frame& frame) {
    if (kind_.writes || written_[at] != bytes) memory_.write(at, written_[at] = bytes);
    v1::MeshUpdate& update = *frame.add_updates();
    update.set_mesh(mesh);
    update.mutable_shared_positions()->set_offset(at);
    update.mutable_shared_positions()->set_size(bytes.size());
    at += aligned(bytes.size());
  }
  void add_on_host(uint32_t mesh, const std::vector<std::byte>& bytes, std::vector<client::FrameUpdate>& updates) {
    const std::span<std::byte> room = stream_.input(bytes.size());
    std::copy(bytes.begin(), bytes.end(), room.begin());
    updates.push_back({.mesh = mesh, .positions = room});
  }
  client::FrameOutput receive() {
    while (kind_.polls)
      if (auto output = stream_.receive_within(std::chrono::milliseconds(0))) return std::move(*output);
    return stream_.receive();
  }
  void keep(double latency, const v1::FrameMetrics& m) {
    times_.push_back({latency, m.step_milliseconds(), m.engine_milliseconds(), m.decode_milliseconds(),
                      m.encode_milliseconds(), m.queue_milliseconds()});
    for (const v1::StageTime& stage : m.stages()) stages_[stage.stage()].push_back(stage.milliseconds());
  }

  const LaneKind kind_;
  const DeviceMemory memory_;
  const uint64_t bytes_in_;  ///< of the positions of a frame
  const uint64_t contacts_;  ///< bytes for them, before the positions
  client::FrameStream stream_;
  uint64_t id_ = 0;
  std::map<uint64_t, std::vector<std::byte>> written_;
  std::vector<FrameTime> times_;
  std::map<std::string, std::vector<double>> stages_;
};

v1::Scene make_scene(client::Client& client, const test::Case& first) {
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_accuracy(v1::ACCURACY_CERTIFIED);
  spec.set_backend(v1::BACKEND_CUDA);
  std::vector<client::MeshInput> meshes;
  for (const MeshSpec& mesh : first.meshes)
    meshes.push_back({.name = "mesh " + std::to_string(meshes.size()),
                      .vertex_count = mesh.vertex_count,
                      .triangles = mesh.triangles});
  return client.create_scene(spec, meshes);
}

Json quantiles(std::vector<double> ms) { return {{"p50", cli::median(ms)}, {"p99", cli::quantile(ms, 0.99)}}; }

Json lane_json(const Lane& lane) {
  const auto of = [&](const auto& value) {
    std::vector<double> out;
    for (const FrameTime& time : lane.times()) out.push_back(value(time));
    return out;
  };
  const auto latency = of([](const FrameTime&t) { return t.latency; }), step = of([](const auto&t) { return t.step; });
  return {{"lane", lane.kind().name},
          {"latency_ms", quantiles(latency)},
          {"step_ms", quantiles(step)},
          {"over_step_ms", quantiles(of([](const FrameTime& t) { return t.latency - t.step; }))},
          {"latency_to_step", cli::median(latency) / cli::median(step)},
          {"engine_ms", cli::median(of([](const FrameTime& t) { return t.engine; }))},
          {"over_engine_ms", quantiles(of([](const FrameTime& t) { return t.latency - t.engine; }))},
          {"decode_ms", cli::median(of([](const FrameTime& t) { return t.decode; }))},
          {"encode_ms", cli::median(of([](const FrameTime& t) { return t.encode; }))},
          {"queue_ms", cli::median(of([](const FrameTime& t) { return t.queue; }))},
          {"stage_ms", lane.stages()}};
}

test::BenchInput input_of(const Options& options) {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0)
    throw std::runtime_error("no CUDA device can be used");
  const auto inputs = test::bench_inputs(options.scene, options.scale);
  if (inputs.empty()) throw std::runtime_error("scene " + options.scene + " is not here");
  return inputs.front();
}

class DeviceBench {
 public:
  explicit DeviceBench(const Options& options)
      : options_(options), input_(input_of(options)), client_(client::Client::connect(daemon_.address())) {
    const test::Case first = input_.at(0, options.frames);
    uint64_t bytes_in = 0;
    for (const test::Positions& positions : first.end)
      bytes_in += aligned(positions.size() * position_bytes(Scalar::kF32));
    for (const LaneKind& kind : kLanes)
      lanes_.push_back(std::make_unique<Lane>(kind, client_, scene_ = make_scene(client_, first), options, bytes_in));
  }

  Json run() {
    for (int i = -options_.warm_up; i < options_.frames; ++i) play(i);
    Json lanes = Json::array();
    for (const auto& lane : lanes_) lanes.push_back(lane_json(*lane));
    const Json run = {{"scene", options_.scene},
                      {"vertices", scene_.vertex_count()},
                      {"triangles", scene_.triangle_count()},
                      {"frames", options_.frames},
                      {"contacts", contacts_},
                      {"lanes", lanes}};
    return {{"device", scene_.device()},
            {"settings",
             {{"mode", "ccd"}, {"accuracy", "certified"}, {"position_format", "f32"}, {"warm_up", options_.warm_up}}},
            {"runs", Json::array({run})}};
  }

 private:
  /// A frame over every lane; each in turn goes first. Below 0 it warms up.
  void play(int i) {
    const test::Case now = input_.at(std::max(i, 0), options_.frames);
    for (size_t k = 0; k < lanes_.size(); ++k) {
      Lane& lane = *lanes_[(k + static_cast<size_t>(i + options_.warm_up)) % lanes_.size()];
      lane.run(now.start, false);  // so that the frame begins where its step does
      const uint64_t count = lane.run(now.end, i >= 0);
      if (k > 0 && count != contacts_) throw std::runtime_error("lanes differ in their contacts");
      contacts_ = count;
    }
  }

  const Options& options_;
  const test::BenchInput input_;
  const cli::OwnDaemon daemon_{{.tcp = true, .cuda_ipc = true}};
  client::Client client_;
  v1::Scene scene_;
  std::vector<std::unique_ptr<Lane>> lanes_;
  uint64_t contacts_ = 0;  ///< of the last frame
};

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  CLI::App app{"Whole frames of a simulator on the daemon's GPU, contacts on the device and on the host, as JSON"};
  app.add_option("--scene", options.scene, "Real frames of the data folder, or a procedural scene");
  app.add_option("--scale", options.scale, "Of a procedural scene");
  app.add_option("--frames", options.frames, "That are counted")->check(CLI::PositiveNumber);
  app.add_option("--warm-up", options.warm_up, "That are not")->check(CLI::NonNegativeNumber);
  app.add_option("--output-mb", options.output_mb, "Room for the contacts of a frame")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  std::printf("%s\n", DeviceBench(options).run().dump(2).c_str());
} catch (const std::exception& e) {
  std::fprintf(stderr, "collided_device_bench: %s\n", e.what());
  return 1;
}
