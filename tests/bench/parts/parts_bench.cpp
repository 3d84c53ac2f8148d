// One scene in parts on several devices, beside the scene on one device and what a model of the cost predicts.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/bench/inputs.hpp"
#include "tests/bench/parts/consecutive_frames.hpp"
#include "tests/bench/parts/cost_model.hpp"
#include "tests/bench/report.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

using nlohmann::ordered_json;

struct Options {
  SceneSpec spec;
  std::string scene, backend = "cpu", engine = "octree", date, commit;
  std::vector<size_t> parts = {1, 2};
  std::vector<int> devices;
  double scale = 1, seconds = kFrameSeconds;
  int steps = 20, warm_up = 12;  ///< in which shares become even
};

/// What the steps of one way to run a scene were like; a value for each step that counts.
struct Run {
  std::vector<uint64_t> digests;  ///< of results
  std::vector<double> step_ms, wall_ms, imbalance;
  std::vector<std::vector<double>> part_ms;  ///< of each part
  std::map<std::string, std::vector<double>> stage_ms;
  std::vector<bool> is_clean;  ///< nothing was allocated, and nothing ran again

  FrameResult last;                                              ///< without contacts
  uint64_t contacts = 0, contact_bytes = 0, position_bytes = 0;  ///< of the last step
  uint64_t triangles = 0;
  std::map<std::string, uint64_t> device_bytes;  ///< of each part, or all

  void add(FrameResult result, double wall);
  void add_parts(const std::vector<ShardFacts>& parts);
};

void Run::add(FrameResult result, double wall) {
  digests.push_back(digest(result));
  step_ms.push_back(result.step_milliseconds);
  wall_ms.push_back(wall);
  is_clean.push_back(result.replays == 0 && result.allocations == 0);
  std::map<std::string, double> sums;
  for (const StageTime& stage : result.stages) sums[stage.stage] += stage.milliseconds;
  for (const auto& [stage, ms] : sums) {
    stage_ms[stage].resize(step_ms.size());
    stage_ms[stage].back() = ms;
  }
  for (auto& [stage, ms] : stage_ms) ms.resize(step_ms.size());
  contacts = contact_bytes = 0;
  for_each_kind(
      [&](ContactKind, ContactSet& set) {
        contacts += set.size();
        for_each_field(
            [&](ContactField, const auto& column) { contact_bytes += column.size() * sizeof(*column.data()); }, set);
        set = {};
      },
      static_cast<PerKind<ContactSet>&>(result));
  if (!result.shards.empty()) add_parts(result.shards);
  last = std::move(result);
}
void Run::add_parts(const std::vector<ShardFacts>& parts) {
  part_ms.resize(parts.size());
  double sum = 0, most = 0;
  for (size_t k = 0; k < parts.size(); ++k) {
    part_ms[k].push_back(parts[k].step_milliseconds);
    sum += parts[k].step_milliseconds, most = std::max(most, parts[k].step_milliseconds);
  }
  imbalance.push_back(sum > 0 ? most * static_cast<double>(parts.size()) / sum : 1);
}

Run run(const ConsecutiveFrames& frames, const Options& o, const std::vector<Device>& devices) {
  SceneSpec spec = o.spec;
  spec.meshes = frames.meshes();
  spec.part_devices = devices;
  const auto detector = Detector::create(std::move(spec));
  const auto slot = detector->make_slot();
  Run run;
  for (size_t i = 0; i < frames.count(); ++i) {
    const FrameInput input = moved_to_slot(frames.input(i), *slot);
    const auto begin = std::chrono::steady_clock::now();
    slot->send(input.updates);
    FrameResult result = detector->detect({.updates = {}, .slot = slot});
    const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - begin;
    if (i < static_cast<size_t>(o.warm_up)) continue;
    run.add(std::move(result), wall.count());
    run.position_bytes = 0;
    for (const MeshPositions& update : input.updates) run.position_bytes += update.start.size() + update.end.size();
  }
  run.triangles = detector->topology().triangles.size();
  for (const MemoryPart& part : detector->memory())
    run.device_bytes[devices.empty() ? "all" : part.part.substr(0, part.part.find('.'))] += part.bytes;
  return run;
}

/// Steps to compare two runs by: a step that runs again takes twice as long, whichever run it is. All, if there is none
/// that is clean in both.
std::vector<size_t> comparable(const Run& a, const Run& b) {
  std::vector<size_t> clean, all;
  for (size_t i = 0; i < a.step_ms.size(); ++i) {
    all.push_back(i);
    if (a.is_clean[i] && b.is_clean[i]) clean.push_back(i);
  }
  return clean.empty() ? all : clean;
}
double median_of(const std::vector<double>& values, const std::vector<size_t>& steps) {
  std::vector<double> chosen;
  for (const size_t i : steps) chosen.push_back(values[i]);
  return median(std::move(chosen));
}
std::map<std::string, double> stages_of(const Run& run, const std::vector<size_t>& steps) {
  std::map<std::string, double> all;
  for (const auto& [stage, ms] : run.stage_ms) all[stage] = median_of(ms, steps);
  return all;
}

ordered_json report(const Run& run, const std::vector<size_t>& steps) {
  return {{"step_ms", median_of(run.step_ms, steps)},
          {"wall_ms", median_of(run.wall_ms, steps)},
          {"stage_ms", stages_of(run, steps)},
          {"clean_steps", std::ranges::count(run.is_clean, true)},
          {"contacts", run.contacts},
          {"registrations", run.last.counts.registrations},
          {"tests", run.last.counts.tests},
          {"pairs", run.last.counts.pairs},
          {"device_bytes", run.device_bytes}};
}
/// Step by step: a scene's steps are not all alike.
double speed_up(const std::vector<double>& one, const std::vector<double>& in_parts, const std::vector<size_t>& steps) {
  std::vector<double> ratios;
  for (const size_t i : steps) ratios.push_back(one[i] / in_parts[i]);
  return median(std::move(ratios));
}

/// `bytes`: a step brings all positions to each part; of its contacts each comes from one.
ordered_json report(const Run& run, const Run& one, const std::vector<Device>& devices) {
  const std::vector<size_t> steps = comparable(one, run);
  ordered_json names = ordered_json::array(), part_ms = ordered_json::array(), shares = ordered_json::array(),
               pairs = ordered_json::array();
  for (const Device& device : devices) names.push_back(to_string(device));
  for (const auto& ms : run.part_ms) part_ms.push_back(median_of(ms, steps));
  for (const ShardFacts& part : run.last.shards) shares.push_back(part.share), pairs.push_back(part.pairs);
  const double predicted = StepCost::of(stages_of(one, steps)).in_parts(devices.size());
  ordered_json out = report(run, steps);
  out["compared_steps"] = steps.size();
  out["devices"] = names;
  out["speed_up"] = speed_up(one.step_ms, run.step_ms, steps);
  out["wall_speed_up"] = speed_up(one.wall_ms, run.wall_ms, steps);
  out["predicted_ms"] = predicted;
  out["predicted_speed_up"] = median_of(one.step_ms, steps) / predicted;
  out["part_ms"] = part_ms;
  out["shares"] = shares;
  out["part_pairs"] = pairs;
  out["max_over_mean"] = median_of(run.imbalance, steps);
  out["bytes_to_devices"] = run.position_bytes * devices.size();
  out["bytes_from_devices"] = run.contact_bytes;
  out["same_bytes"] = run.digests == one.digests;
  return out;
}

/// So many parts, on the named devices in turn; on all that there are if none is named.
std::vector<Device> devices_of(const Options& o, size_t parts) {
  std::vector<Device> all, chosen;
  for (const int ordinal : o.devices) all.push_back({o.spec.device.backend, ordinal});
  if (all.empty())
    for (const DeviceInfo& info : list_devices())
      if (info.device.backend == o.spec.device.backend) all.push_back(info.device);
  if (all.empty()) throw std::runtime_error("there is no device of this backend");
  for (size_t k = 0; k < parts; ++k) chosen.push_back(all[k % all.size()]);
  return chosen;
}

/// A scene on one device, then in each number of parts; false in `is_same` where their results differ.
ordered_json run_scene(const std::string& name, const Options& o, bool& is_same) {
  const auto frames =
      consecutive_frames(name, o.scale, {o.seconds, static_cast<size_t>(o.warm_up) + static_cast<size_t>(o.steps)});
  if (!frames) throw std::runtime_error("no scene is called " + name);
  std::cerr << name << ", on one device\n";
  const Run one = run(*frames, o, {});
  ordered_json in_parts = ordered_json::array();
  for (const size_t parts : o.parts) {
    std::cerr << name << ", in " << parts << " parts\n";
    const std::vector<Device> devices = devices_of(o, parts);
    in_parts.push_back(report(run(*frames, o, devices), one, devices));
    is_same = is_same && in_parts.back()["same_bytes"].get<bool>();
  }
  return {{"scene", name},
          {"triangles", one.triangles},
          {"one", report(one, comparable(one, one))},
          {"in_parts", in_parts}};
}

bool run_all(Options& o) {
  bool is_same = true;
  o.spec.device = devices_of(o, 1).front();
  ordered_json scenes = ordered_json::array();
  const std::vector<std::string> names = o.scene.empty() ? names_of_scenes() : std::vector{o.scene};
  for (const std::string& name : names) scenes.push_back(run_scene(name, o, is_same));
  const ordered_json all{
      {"date", o.date},     {"commit", o.commit},        {"device", device_name(o.spec.device.backend)},
      {"engine", o.engine}, {"steps", o.steps},          {"warm_up", o.warm_up},
      {"scale", o.scale},   {"step_seconds", o.seconds}, {"scenes", scenes}};
  std::cout << all.dump(2) << "\n";
  return is_same;
}

void add_options(CLI::App& app, Options& o) {
  app.add_option("--backend", o.backend, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
  app.add_option("--parts", o.parts, "Numbers of parts; a run for each, after one without parts")
      ->check(CLI::Range(size_t{1}, kMaxShards))
      ->capture_default_str();
  app.add_option("--devices", o.devices, "Ordinals of the devices that parts are on in turn; default: all")
      ->delimiter(',');
  app.add_option("--engine", o.engine, "octree, lbvh or auto")
      ->check(CLI::IsMember({"octree", "lbvh", "auto"}))
      ->capture_default_str();
  app.add_option("--threads", o.spec.threads, "CPU threads, of all parts together; 0: all cores")
      ->capture_default_str();
  app.add_option("--scene", o.scene, "One scene; default: all");
  app.add_option("--scale", o.scale, "Refines the grids")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--step-seconds", o.seconds, "How long procedural scenes move in a step")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--steps", o.steps, "Steps that count")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--warm-up", o.warm_up, "Steps before, in which shares become even")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--date", o.date, "Recorded in the result");
  app.add_option("--commit", o.commit, "Recorded in the result");
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided;
  CLI::App app("Runs scenes in parts on several devices, as JSON; exits with 1 where results differ from one device's");
  test::Options options;
  test::add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  options.spec.device.backend = options.backend == "cuda" ? Backend::kCuda : Backend::kCpu;
  options.spec.engine = options.engine == "octree" ? Engine::kOctree
                        : options.engine == "lbvh" ? Engine::kLbvh
                                                   : Engine::kAuto;
  options.spec.reuse = Reuse::kOff;
  options.spec.scalar = Scalar::kF32;
  try {
    return test::run_all(options) ? 0 : 1;
  } catch (const std::exception& e) {
    std::cerr << "collided_parts_bench: " << e.what() << "\n";
    return 1;
  }
}
