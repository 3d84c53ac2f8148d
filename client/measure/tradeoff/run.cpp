// Runs levels, deltas and position formats over one step. Each format has one scene on the daemon; its frames repeat
// the step, and each has its own level and delta. The levels take turns, so that noise affects all of them alike.

#include "client/measure/tradeoff/run.hpp"

#include <algorithm>

#include "client/app/daemon/connection.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/progress.hpp"
#include "client/app/report/json.hpp"
#include "client/cpp/positions.hpp"
#include "client/measure/stage_medians.hpp"
#include "client/measure/tradeoff/judge.hpp"

namespace collided::cli {

namespace {

v1::Accuracy accuracy_of(std::string level) {
  std::transform(level.begin(), level.end(), level.begin(), [](unsigned char c) { return std::toupper(c); });
  v1::Accuracy accuracy{};
  if (!v1::Accuracy_Parse("ACCURACY_" + level, &accuracy)) throw std::logic_error("no level " + level);
  return accuracy;
}

std::vector<Run> planned_runs(const TradeoffSettings& settings, const std::string& format) {
  std::vector<Run> runs;
  for (const std::string& level : settings.levels) {
    if (level == "exact" && client::is_quantized(format_of(format)))
      continue;  // decides on the given positions, which it does not know
    if (level == "fast")
      runs.push_back({.format = format, .level = level});
    else
      for (const double delta : settings.deltas) runs.push_back({.format = format, .level = level, .delta = delta});
  }
  return runs;
}

/// Sends the step, with one frame in flight so that no frame's time depends on its neighbours.
class Stepper {
 public:
  Stepper(client::FrameStream stream, const StepInput& step, v1::SceneSpec spec)
      : stream_(std::move(stream)), step_(step), spec_(std::move(spec)) {}

  client::FrameOutput run(const std::string& level, std::optional<double> delta) {
    v1::Frame frame = step_frame(step_, ++last_id_, spec_);
    frame.set_accuracy(accuracy_of(level));
    if (delta) frame.set_delta(*delta);
    return run_frame(stream_, frame);
  }
  void finish() { stream_.finish(); }

 private:
  client::FrameStream stream_;
  const StepInput& step_;
  const v1::SceneSpec spec_;
  uint64_t last_id_ = 0;
};

uint64_t count_flag(const client::FrameOutput& output, v1::ContactFlag flag) {
  uint64_t n = 0;
  for (const client::Contacts* contacts : {&output.vertex_triangle, &output.edge_edge})
    for (const uint8_t flags : contacts->flags) n += (flags & flag) != 0;
  return n;
}

Work work_of(const client::FrameOutput& output) {
  const v1::FrameCounts& counts = output.done.metrics().counts();
  return {.survivors_vertex_triangle = counts.survivors_vertex_triangle(),
          .survivors_edge_edge = counts.survivors_edge_edge(),
          .exact_decisions = counts.exact_decisions(),
          .certified = count_flag(output, v1::CONTACT_FLAG_CERTIFIED),
          .near = count_flag(output, v1::CONTACT_FLAG_NEAR),
          .capped = count_flag(output, v1::CONTACT_FLAG_CAPPED)};
}

bool is_narrow(const std::string& stage) { return stage.starts_with("narrow_") || stage == "exact"; }

/// Adds two sums as stages, so that medians of the sums are taken as well.
v1::FrameMetrics with_sums(v1::FrameMetrics metrics) {
  double narrow = 0, stages = 0;
  for (const v1::StageTime& stage : metrics.stages()) {
    stages += stage.milliseconds();
    if (is_narrow(stage.stage())) narrow += stage.milliseconds();
  }
  for (const auto& [name, ms] : {std::pair{"sum of narrow", narrow}, std::pair{"sum of stages", stages}}) {
    v1::StageTime& sum = *metrics.add_stages();
    sum.set_stage(name);
    sum.set_milliseconds(ms);
  }
  return metrics;
}

Times median_times(const std::vector<v1::FrameMetrics>& frames) {
  Times times;
  times.stage = median_stages(frames).get<std::map<std::string, double>>();
  const auto extract = [&](const char* name) { return times.stage.extract(name).mapped(); };
  times.narrow = extract("sum of narrow");
  times.stages = extract("sum of stages");
  times.total = extract("total");
  return times;
}

/// The first round, which is not timed, warms up and judges the contacts.
void run_rounds(const TradeoffSettings& settings, Stepper& stepper, const Truth& truth, std::vector<Run>& runs) {
  std::vector<std::vector<v1::FrameMetrics>> metrics(runs.size());
  Progress progress;
  const int total = static_cast<int>(runs.size()) * (settings.repeats + 1);
  for (int i = 0; i < total; ++i) {
    const size_t at = static_cast<size_t>(i) % runs.size();
    const client::FrameOutput output = stepper.run(runs[at].level, runs[at].delta);
    if (static_cast<size_t>(i) < runs.size()) {
      runs[at].score = judge(truth, output);
      runs[at].work = work_of(output);
      runs[at].bytes = output.done.metrics().bytes_in();
    } else {
      metrics[at].push_back(with_sums(output.done.metrics()));
    }
    progress.show("frames with " + runs[at].format + " positions", i + 1, total);
  }
  for (size_t i = 0; i < runs.size(); ++i) runs[i].times = median_times(metrics[i]);
}

Truth find_truth(Stepper& stepper) {
  const client::FrameOutput close = stepper.run("exact", 0);
  return exact_truth(close, stepper.run("exact", kWideDelta));
}

class Measurement {
 public:
  Measurement(const TradeoffSettings& settings, const StepInput& step, Tradeoff& result)
      : settings_(settings), step_(step), connection_(settings.server), result_(result) {
    if (!settings.truth.empty()) given_ = read_truth(settings.truth);
    result_.name = step.name;
    result_.input = step.description;
    result_.version = connection_->server_info().version();
    result_.thickness = settings.detection.thickness;
    result_.repeats = settings.repeats;
  }

  void measure(const std::string& format) {
    const Truth exact = uses_given_truth(format) ? Truth{} : find_truth(format);
    const Truth& truth = uses_given_truth(format) ? *given_ : exact;
    std::vector<Run> runs = planned_runs(settings_, format);
    play(format, [&](Stepper& stepper) { run_rounds(settings_, stepper, truth, runs); });
    result_.truths.push_back({format, uses_given_truth(format) ? settings_.truth : "exact",
                              truth.vertex_triangle.size(), truth.edge_edge.size(), truth.bounded});
    result_.runs.insert(result_.runs.end(), runs.begin(), runs.end());
  }

 private:
  /// A given truth holds for the given positions: rounded to floats, they may touch elsewhere. What is encoded is
  /// judged by what was meant.
  bool uses_given_truth(const std::string& format) const { return given_ && (format != "f32" || !step_.is_double); }

  /// Of the positions as that format gives them; encoded ones are judged by those before.
  Truth find_truth(const std::string& format) {
    Truth truth;
    play(client::is_quantized(format_of(format)) ? "f64" : format,
         [&](Stepper& stepper) { truth = cli::find_truth(stepper); });
    return truth;
  }

  /// On a scene of its own.
  template <class Body>
  void play(const std::string& format, const Body& body) {
    v1::SceneSpec spec = scene_spec(settings_.server, settings_.detection, format_of(format));
    spec.set_display_name("tradeoff");
    grow_box(spec, step_.start);
    grow_box(spec, step_.end);
    const SceneGuard scene = connection_.create_scene(spec, mesh_inputs(step_.meshes));
    describe(*scene);
    Stepper stepper(connection_.stream(*scene, 1), step_, spec);
    body(stepper);
    stepper.finish();
  }

  void describe(const v1::Scene& scene) {
    result_.backend = name_of(scene.spec().backend());
    result_.device = scene.device();
    result_.vertices = scene.vertex_count();
    result_.edges = scene.edge_count();
    result_.triangles = scene.triangle_count();
  }

  const TradeoffSettings& settings_;
  const StepInput& step_;
  Connection connection_;
  std::optional<Truth> given_;
  Tradeoff& result_;
};

}  // namespace

void check_runs(const TradeoffSettings& settings) {
  for (const std::string& format : settings.formats)
    if (planned_runs(settings, format).empty())
      throw UsageError("--formats " + format + " needs --levels fast, guarded or certified; exact is not for it");
}

void measure(const TradeoffSettings& settings, const StepInput& step, Tradeoff& result) {
  Measurement measurement(settings, step, result);
  for (const std::string& format : settings.formats) measurement.measure(format);
}

}  // namespace collided::cli
