#include "tests/bench/engines.hpp"

#include <algorithm>
#include <ostream>
#include <stdexcept>

namespace collided::test {
namespace {

using Count = uint64_t FrameCounts::*;
constexpr std::pair<const char*, Count> kCounts[] = {
    {"tests", &FrameCounts::tests}, {"registrations", &FrameCounts::registrations}, {"pairs", &FrameCounts::pairs}};

EngineRun run_engine(const BenchInput& input, const SceneSpec& spec, const std::string& name, int steps, int warm_up) {
  const auto detector = Detector::create(spec_for(input.at(0, steps), spec));
  EngineRun run{input.name, name, detector->topology().triangles.size(), {}};
  play_steps(*detector, input, spec, {steps, warm_up}, [&](const auto& play) { run.steps.push_back(play().counts); });
  return run;
}

void check_pairs(const EngineRun& run, const EngineRun& other) {
  const auto same = [](const FrameCounts& a, const FrameCounts& b) { return a.pairs == b.pairs; };
  if (!std::ranges::equal(run.steps, other.steps, same))
    throw std::runtime_error(run.scene + ": " + run.engine + " and " + other.engine + " find different pairs");
}

uint64_t mean(const std::vector<FrameCounts>& steps, Count count) {
  uint64_t sum = 0;
  for (const FrameCounts& step : steps) sum += step.*count;
  return (sum + steps.size() / 2) / steps.size();
}

void write_run(std::ostream& out, const EngineRun& run) {
  out << "    {\"scene\": \"" << run.scene << "\", \"triangles\": " << run.triangles << ", \"engine\": \"" << run.engine
      << "\", \"counts\": {";
  for (const auto& [name, count] : kCounts)
    out << (count == kCounts[0].second ? "\"" : ", \"") << name << "\": " << mean(run.steps, count);
  out << "}";
  for (const auto& [name, count] : kCounts) {
    out << ",\n     \"" << name << "_by_step\": [";
    for (size_t i = 0; i < run.steps.size(); ++i) out << (i == 0 ? "" : ", ") << run.steps[i].*count;
    out << "]";
  }
  out << ",\n     \"levels_by_step\": [";
  for (size_t i = 0; i < run.steps.size(); ++i)
    out << (i == 0 ? "" : ", ") << "[" << run.steps[i].top_level << ", " << run.steps[i].base_level << "]";
  out << "]}";
}

}  // namespace

std::vector<EngineRun> compare_engines(const BenchInput& input, SceneSpec spec, const std::vector<NamedEngine>& engines,
                                       int steps, int warm_up) {
  std::vector<EngineRun> runs;
  for (const auto& [name, engine] : engines) {
    spec.engine = engine;
    runs.push_back(run_engine(input, spec, name, steps, warm_up));
    check_pairs(runs.back(), runs.front());
  }
  return runs;
}

void write_engines(std::ostream& out, const std::vector<EngineRun>& runs) {
  out << "[\n";
  for (size_t i = 0; i < runs.size(); ++i) {
    write_run(out, runs[i]);
    out << (i + 1 < runs.size() ? ",\n" : "\n");
  }
  out << "  ]";
}

}  // namespace collided::test
