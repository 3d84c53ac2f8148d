#include "tests/bench/levels.hpp"

#include <algorithm>
#include <limits>
#include <ostream>

namespace collided::test {
namespace {

struct Variant {
  const char* name;
  Accuracy accuracy;
  Report report;
};
constexpr Variant kVariants[] = {{"fast", Accuracy::kFast, Report::kAll},
                                 {"guarded", Accuracy::kGuarded, Report::kAll},
                                 {"certified", Accuracy::kCertified, Report::kAll},
                                 {"exact", Accuracy::kExact, Report::kAll},
                                 {"certified earliest", Accuracy::kCertified, Report::kEarliestOnly},
                                 {"certified any", Accuracy::kCertified, Report::kAnyHit}};

struct Cost {
  double narrow = std::numeric_limits<double>::infinity(), total = narrow;
};

Cost cost_of(const FrameResult& result) {
  Cost cost{0, 0};
  for (const StageTime& stage : result.stages) {
    cost.total += stage.milliseconds;
    if (stage.stage.starts_with("narrow_")) cost.narrow += stage.milliseconds;
  }
  return cost;
}

void run_step(Detector& detector, FrameInput input, int repeats, std::vector<LevelRun>& runs) {
  std::vector<Cost> best(runs.size());
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (size_t i = 0; i < runs.size(); ++i) {
      input.accuracy = kVariants[i].accuracy;
      input.report = kVariants[i].report;
      const FrameResult result = detector.detect(input);
      const Cost cost = cost_of(result);
      best[i] = {std::min(best[i].narrow, cost.narrow), std::min(best[i].total, cost.total)};
      if (repeat == 0) runs[i].contacts += result.vertex_triangle.size() + result.edge_edge.size();
    }
  for (size_t i = 0; i < runs.size(); ++i) {
    runs[i].narrow_ms += best[i].narrow;
    runs[i].total_ms += best[i].total;
  }
}

}  // namespace

LevelReport compare_levels(const BenchInput& input, const SceneSpec& spec, int steps, int repeats) {
  LevelReport report{input.name, 0, {}};
  for (const Variant& variant : kVariants) report.runs.push_back({variant.name});
  const auto detector = Detector::create(spec_for(input.at(0, steps), spec));
  report.triangles = detector->topology().triangles.size();
  for (int step = 0; step < steps; ++step) {
    const Frame frame(input.at(step, steps), spec.mode, spec.scalar, step == 0);
    if (step == 0) detector->detect(frame.input());  // static meshes come once
    run_step(*detector, Frame(input.at(step, steps), spec.mode, spec.scalar, false).input(), repeats, report.runs);
  }
  return report;
}

void write_levels(std::ostream& out, const std::vector<LevelReport>& reports) {
  out << "[\n";
  for (size_t i = 0; i < reports.size(); ++i) {
    const LevelReport& r = reports[i];
    out << "    {\"scene\": \"" << r.scene << "\", \"triangles\": " << r.triangles << ", \"levels\": [\n";
    for (size_t k = 0; k < r.runs.size(); ++k) {
      const LevelRun& run = r.runs[k];
      out << "      {\"level\": \"" << run.name << "\", \"narrow_ms\": " << run.narrow_ms
          << ", \"narrow_ratio\": " << run.narrow_ms / r.runs[0].narrow_ms << ", \"total_ms\": " << run.total_ms
          << ", \"total_ratio\": " << run.total_ms / r.runs[0].total_ms << ", \"contacts\": " << run.contacts << "}"
          << (k + 1 < r.runs.size() ? ",\n" : "\n");
    }
    out << "    ]}" << (i + 1 < reports.size() ? ",\n" : "\n");
  }
  out << "  ]";
}

}  // namespace collided::test
