// The charts of a load's report.

#include "client/measure/load/report/plots.hpp"

#include <algorithm>
#include <cmath>

#include "client/app/report/numbers.hpp"

namespace collided::cli::load {

namespace {

constexpr double kMinMs = 1e-3;       // what a logarithmic axis can show of 0
constexpr double kWorthAPoint = 0.5;  // seconds

std::string ms_hint(double ms) { return milliseconds_text(ms) + " ms"; }

/// From the smallest to the largest of all lines, and of `bound`.
Axis ms_axis(const std::vector<Line>& lines, double bound = 0) {
  double min = bound > 0 ? bound : 1e9, max = std::max(bound, kMinMs);
  for (const Line& line : lines)
    for (const auto& [x, y] : line.points) min = std::min(min, y), max = std::max(max, y);
  return log_ms_axis("", std::max(std::min(min, max), kMinMs), max);
}

/// Percentiles are spread so that 90, 99, 99.9 are as far apart.
double spread(double percentile) { return -std::log10(1 - percentile / 100); }

Line curve(const std::string& name, const Json& points, double end) {
  Line line{.name = name, .points = {}, .hints = {}};
  for (const Json& point : points) {
    const double percentile = point.at(0), ms = std::max(point.at(1).get<double>(), kMinMs);
    line.points.emplace_back(percentile < 100 ? spread(percentile) : end, ms);
    line.hints.push_back((percentile < 100 ? format_double("%.6g %%: ", percentile) : "max: ") + ms_hint(ms));
  }
  return line;
}

Chart percentile_chart(const Json& outcome) {
  const bool is_open = outcome.at("load").at("loop") == "open";
  const double frames = std::max(10.0, outcome.at("latency_ms").at("count").get<double>()),
               end = std::log10(frames) + 0.2;
  Chart chart{.title = "Latency by percentile",
              .x = {.label = "percentile of frames", .min = 0, .max = end},
              .y = {},
              .lines = {}};
  chart.lines.push_back(curve(is_open ? "from when due" : "latency", outcome.at("latency_curve"), end));
  if (is_open) chart.lines.push_back(curve("from when sent", outcome.at("service_curve"), end));
  constexpr const char* kTicks[] = {"0", "90", "99", "99.9", "99.99", "99.999", "99.9999"};
  constexpr double kRoom = 0.35;  // for the last one
  for (int i = 0; i < std::min(7.0, end - kRoom); ++i) chart.x.ticks.push_back({static_cast<double>(i), kTicks[i]});
  chart.x.ticks.push_back({end, "max"});
  chart.y = ms_axis(chart.lines);
  return chart;
}

/// Of each second, placed at its end.
template <class Value>
Line over_time(const std::string& name, const Json& series, const Value& value) {
  Line line{.name = name, .points = {}, .hints = {}};
  for (const Json& second : series) {
    const double begin = second.at("begin_seconds"), end = second.at("end_seconds"), y = value(second, end - begin);
    if (end - begin < kWorthAPoint || y < 0) continue;
    line.points.emplace_back(end, y);
    line.hints.push_back(format_double("%.0f s: ", end) + format_double("%.4g", y));
  }
  return line;
}

Axis time_axis(const Json& series) {
  Axis axis = linear_axis("seconds", series.back().at("end_seconds"));
  axis.max = series.back().at("end_seconds");
  std::erase_if(axis.ticks, [&](const Tick& tick) { return tick.value > axis.max; });
  return axis;
}

Chart latency_over_time(const Json& outcome) {
  const Json& series = outcome.at("series");
  const auto of = [&](const char* name, const char* key) {
    return over_time(name, series, [key](const Json& second, double) {
      return second.at("answered") > 0 ? std::max(second.at(key).get<double>(), kMinMs) : -1;
    });
  };
  Chart chart{.title = "Latency of the frames answered in each second",
              .x = time_axis(series),
              .y = {},
              .lines = {of("p50", "p50_ms"), of("p99", "p99_ms"), of("max", "max_ms")}};
  chart.y = ms_axis(chart.lines);
  return chart;
}

Chart frames_over_time(const Json& outcome) {
  const Json& series = outcome.at("series");
  const auto of = [&](const char* name, const auto& count) {
    return over_time(name, series,
                     [&](const Json& second, double seconds) { return static_cast<double>(count(second)) / seconds; });
  };
  const auto get = [](const char* key) { return [key](const Json& second) { return second.at(key).get<uint64_t>(); }; };
  Chart chart{.title = "Frames a second",
              .x = time_axis(series),
              .y = {},
              .lines = {of("sent", get("sent")), of("answered", get("answered"))}};
  const Json& frames = outcome.at("frames");
  if (frames.at("skipped") > 0 || frames.at("refused") > 0)
    chart.lines.push_back(of("skipped or refused", [&](const Json& second) {
      return second.at("skipped").get<uint64_t>() + second.at("refused").get<uint64_t>();
    }));
  double max = 0;
  for (const Line& line : chart.lines)
    for (const auto& [x, y] : line.points) max = std::max(max, y);
  chart.y = linear_axis("", max);
  return chart;
}

Chart trial_chart(const Json& search) {
  Line line{.name = "p99", .points = {}, .hints = {}};
  std::vector<Json> trials(search.at("trials").begin(), search.at("trials").end());
  const auto rate_of = [](const Json& trial) { return trial.at("frames_per_second").get<double>(); };
  std::sort(trials.begin(), trials.end(), [&](const Json& a, const Json& b) { return rate_of(a) < rate_of(b); });
  for (const Json& trial : trials) {
    const double ms = std::max(trial.at("p99_ms").get<double>(), kMinMs);
    const std::string failure = trial.at("failure");
    line.points.emplace_back(rate_of(trial), ms);
    line.hints.push_back(format_double("%.4g frames/s: ", rate_of(trial)) + ms_hint(ms) + ", " +
                         (failure.empty() ? "held" : failure));
  }
  const double bound = search.at("p99_ms");
  return {.title = "Trials: 99th percentile of the latency",
          .x = linear_axis("frames a second, all streams", rate_of(trials.back())),
          .y = ms_axis({line}, bound),
          .lines = {line},
          .bound = bound,
          .bound_name = "bound, " + ms_hint(bound)};
}

}  // namespace

std::vector<Chart> plots_of(const Json& outcome) {
  std::vector<Chart> charts;
  if (outcome.contains("find_max") && !outcome.at("find_max").at("trials").empty())
    charts.push_back(trial_chart(outcome.at("find_max")));
  if (outcome.at("latency_ms").at("count") > 0) charts.push_back(percentile_chart(outcome));
  if (outcome.at("series").size() > 2) {
    charts.push_back(latency_over_time(outcome));
    charts.push_back(frames_over_time(outcome));
  }
  return charts;
}

}  // namespace collided::cli::load
