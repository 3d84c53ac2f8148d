// Results of 'collidectl bench' as JSON and as a table.

#include "client/measure/bench/report.hpp"

#include <cstdio>

#include "client/app/options/values.hpp"
#include "client/app/report/numbers.hpp"
#include "client/measure/stage_medians.hpp"
#include "client/measure/statistics.hpp"

namespace collided::cli {

namespace {

Json step_times(const std::vector<v1::FrameMetrics>& steps) {
  std::vector<double> ms;
  for (const v1::FrameMetrics& step : steps) ms.push_back(step.step_milliseconds());
  return {{"median", median(ms)}, {"p95", quantile(ms, 0.95)}, {"min", quantile(ms, 0)}};
}

Json stage_times(const std::vector<v1::FrameMetrics>& steps) {
  Json stages = median_stages(steps);
  stages.erase("total");  // not a stage: the daemon's time, including waits
  return stages;
}

Json counts_of(const std::vector<v1::FrameMetrics>& steps) {
  Json out = counts_json(steps.back().counts());
  uint64_t replays = 0;
  Json engines = Json::object();
  for (const v1::FrameMetrics& step : steps) {
    const std::string engine = name_of(step.broad_phase_engine());
    engines[engine] = engines.value(engine, 0) + 1;
    replays += step.replays();
  }
  out["replays"] = replays;
  out["steps_by_engine"] = engines;
  return out;
}

double mean(const std::vector<v1::FrameMetrics>& steps, uint32_t (v1::FrameMetrics::*count)() const) {
  double sum = 0;
  for (const v1::FrameMetrics& step : steps) sum += (step.*count)();
  return sum / static_cast<double>(steps.size());
}

uint64_t device_bytes(const v1::Scene& scene) {
  uint64_t bytes = 0;
  for (const v1::MemoryPart& part : scene.memory()) bytes += part.bytes();
  return bytes;
}

/// The engine that was requested and, if others found the pairs, those: "auto (octree, lbvh)".
std::string engine_text(const Json& run) {
  std::string text = run.at("engine"), found;
  for (const auto& [name, steps] : run.at("counts").at("steps_by_engine").items())
    found += (found.empty() ? "" : ", ") + name;
  return text == found ? text : text + " (" + found + ")";
}

/// "boxes 0.12, levels 0.034".
template <class Text>
std::string list_text(const Json& object, const Text& text) {
  std::string out;
  for (const auto& [name, value] : object.items())
    if (value.is_number()) out += (out.empty() ? "" : ", ") + name + " " + text(value);
  return out;
}

std::string row(const std::string& scene, const std::string& engine, const std::string& triangles,
                const std::string& median, const std::string& p95, const std::string& min) {
  char line[256];
  std::snprintf(line, sizeof line, "%-18s %-24s %12s %10s %10s %10s\n", scene.c_str(), engine.c_str(),
                triangles.c_str(), median.c_str(), p95.c_str(), min.c_str());
  return line;
}

}  // namespace

Json run_json(const BenchRun& run) {
  const v1::SceneSpec& spec = run.scene.spec();
  Json out = {{"scene", run.name},
              {"triangles", run.scene.triangle_count()},
              {"backend", name_of(spec.backend())},
              {"device", run.scene.device()},
              {"engine", name_of(spec.broad_phase_engine())},
              {"accuracy", name_of(spec.accuracy())},
              {"steps", run.steps.size()},
              {"step_ms", step_times(run.steps)},
              {"stage_ms", stage_times(run.steps)},
              {"counts", counts_of(run.steps)},
              {"device_bytes", device_bytes(run.scene)},
              {"allocations_per_step", mean(run.steps, &v1::FrameMetrics::allocations)},
              {"graph_launches_per_step", mean(run.steps, &v1::FrameMetrics::graph_launches)}};
  if (spec.part_devices_size() > 0) out["part_devices"] = part_devices_json(spec);
  return out;
}

Json bench_json(const std::vector<BenchRun>& runs, int warm_up, const Json& scale) {
  const Json scene = scene_json(runs.front().scene);
  Json settings = {{"warm_up", warm_up}, {"scale", scale}};
  for (const char* name : {"mode", "position_format", "thickness", "delta", "report", "kinds"})
    settings[name] = scene.at(name);
  Json out = {{"device", runs.front().scene.device()}, {"settings", settings}, {"runs", Json::array()}};
  for (const BenchRun& run : runs) out["runs"].push_back(run_json(run));
  return out;
}

std::string bench_head() { return row("scene", "engine", "triangles", "median ms", "p95 ms", "min ms"); }

std::string bench_lines(const Json& run) {
  const Json& ms = run.at("step_ms");
  const auto time = [](const Json& value) { return milliseconds_text(value.get<double>()); };
  const auto count = [](const Json& value) { return count_text(value.get<uint64_t>()); };
  const auto number = [](const Json& value) { return format_double("%g", value.get<double>()); };
  std::string out = row(run.at("scene"), engine_text(run), count(run.at("triangles")), time(ms.at("median")),
                        time(ms.at("p95")), time(ms.at("min")));
  out += "    stages, ms: " + list_text(run.at("stage_ms"), time) + "\n";
  out += "    counts: " + list_text(run.at("counts"), count) + "\n";
  out += "    device_bytes " + count(run.at("device_bytes"));
  for (const char* name : {"allocations_per_step", "graph_launches_per_step"})
    out += std::string(", ") + name + " " + number(run.at(name));
  return out + "\n";
}

}  // namespace collided::cli
