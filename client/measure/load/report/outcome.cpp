// What a load measured, as JSON.

#include "client/measure/load/report/outcome.hpp"

#include <algorithm>
#include <cmath>

#include "client/app/report/numbers.hpp"

namespace collided::cli::load {

namespace {

constexpr double kMaxDifference = 0.01;  // between the tester's counts and the daemon's
constexpr double kBusy = 0.8;            // of a thread's time
constexpr double kLate = 0.1;            // of the latency's p99
constexpr double kMinLateMs = 1;         // what a busy host takes now and then

Json times_json(const Histogram& times) {
  Json out = {{"count", times.count()}, {"mean", times.mean()}, {"min", times.min()}};
  for (const auto& [name, percent] : kPercentiles) out[name] = times.percentile(percent);
  out["max"] = times.max();
  return out;
}

Json refusals_json(const RefusalsByCode& refusals) {
  Json out = Json::object();
  for (const auto& [code, of_code] : refusals) out[code] = {{"count", of_code.count}, {"first", of_code.first}};
  return out;
}

/// At percentiles ever closer to 100, as many of each magnitude, as far as there are frames to tell them apart: 0, 5,
/// ..., 90, 90.5, ..., 99, 99.05, ...
Json curve_json(const Histogram& times) {
  constexpr int kSteps = 18;  // from one magnitude to the next
  Json out = Json::array();
  const auto frames = static_cast<double>(times.count());
  for (double above = 100; above / 100 * frames >= 1; above /= 10)
    for (int i = 0; i < kSteps; ++i) {
      const double percent = 100 - above * (1 - 0.9 * i / kSteps);
      out.push_back({percent, times.percentile(percent)});
    }
  out.push_back({100, times.max()});
  return out;
}

Json stretches_json(const RateProfile& profile) {
  Json out = Json::array();
  for (const Stretch& stretch : profile.stretches())
    out.push_back({{"from", stretch.from}, {"to", stretch.to}, {"seconds", stretch.seconds}});
  return out;
}

Json load_json(const LoadSettings& settings, const Outcome& outcome) {
  const StreamSettings& streams = settings.streams;
  const PaceSettings& pace = settings.pace;
  const bool is_open = is_open_loop(settings);
  Json out = {{"streams", streams.count()},
              {"clients", streams.clients},
              {"scenes_per_client", streams.scenes},
              {"connections", outcome.connections},
              {"window", streams.window},
              {"delivery", streams.latest_wins ? "latest-wins" : "lossless"},
              {"loop", is_open ? "open" : "closed"},
              {"arrivals", !is_open                            ? Json(nullptr)
                           : pace.arrivals == Arrivals::kFixed ? "fixed"
                                                               : "poisson"}};
  if (pace.profile) out["frames_per_second_each"] = stretches_json(*pace.profile);
  return out;
}

Json input_json(const Outcome& outcome) {
  return {{"name", outcome.input}, {"bytes_per_frame", outcome.bytes_per_frame}, {"scene", scene_json(outcome.scene)}};
}

Json frames_json(const Tally& tally) {
  return {{"due", tally.due()},
          {"sent", tally.sent},
          {"answered", tally.answered},
          {"skipped", tally.skipped},
          {"refused", tally.refused_count()},
          {"unanswered", tally.unanswered},
          {"unsent", tally.unsent}};
}

Json throughput_json(const PhaseResult& result) {
  const Tally& tally = result.tally;
  const double seconds = std::max(result.seconds, 1e-9);
  return {{"seconds", result.seconds},
          {"frames_per_second", static_cast<double>(tally.answered) / seconds},
          {"contacts_per_second", static_cast<double>(tally.contacts) / seconds},
          {"bytes_in_per_second", static_cast<double>(tally.bytes_in) / seconds},
          {"bytes_out_per_second", static_cast<double>(tally.bytes_out) / seconds}};
}

Json tester_json(const Outcome& outcome) {
  const PhaseResult& result = outcome.result;
  const double frames = std::max<double>(1, static_cast<double>(result.tally.sent));
  return {{"cpu_ms_per_frame", 1e3 * result.cost.cpu_seconds / frames},
          {"cores", result.cost.cpu_seconds / std::max(result.seconds, 1e-9)},
          {"busiest_thread", result.cost.busiest_thread},
          {"threads", outcome.threads},
          {"delay_ms", times_json(result.tally.delay)}};
}

Json series_json(const std::vector<SeriesPoint>& series) {
  Json out = Json::array();
  for (const SeriesPoint& point : series)
    out.push_back({{"begin_seconds", point.begin},
                   {"end_seconds", point.end},
                   {"sent", point.sent},
                   {"answered", point.answered},
                   {"skipped", point.skipped},
                   {"refused", point.refused},
                   {"p50_ms", point.p50},
                   {"p99_ms", point.p99},
                   {"max_ms", point.max}});
  return out;
}

Json search_json(const LoadSettings& settings, const Outcome& outcome) {
  Json trials = Json::array();
  for (const Trial& trial : outcome.trials)
    trials.push_back({{"frames_per_second", trial.rate},
                      {"held", trial.failure.empty()},
                      {"failure", trial.failure},
                      {"answered", trial.answered},
                      {"p50_ms", trial.p50},
                      {"p99_ms", trial.p99},
                      {"max_ms", trial.max}});
  return {{"p99_ms", settings.find_max.p99_ms},
          {"frames_per_second", outcome.best ? Json(*outcome.best) : Json(nullptr)},
          {"trials", trials}};
}

Json generations_json(const Outcome& outcome) {
  Json out = Json::array();
  for (const Generation& generation : outcome.generations)
    out.push_back({{"setup_seconds", generation.setup_seconds},
                   {"answered", generation.answered},
                   {"p50_ms", generation.p50},
                   {"p99_ms", generation.p99},
                   {"max_ms", generation.max}});
  return out;
}

Json measured_json(const Tally& tally) {
  return {{"latency_ms", times_json(tally.latency)},
          {"service_ms", times_json(tally.service)},
          {"daemon_ms",
           {{"total", times_json(tally.total)},
            {"queue", times_json(tally.queue)},
            {"decode", times_json(tally.decode)},
            {"engine", times_json(tally.engine)},
            {"encode", times_json(tally.encode)}}}};
}

bool is_busy(const PhaseResult& result) { return result.cost.busiest_thread > kBusy; }

bool is_late(const Tally& tally) {
  return tally.delay.percentile(99) > std::max(kMinLateMs, kLate * tally.latency.percentile(99));
}

}  // namespace

bool is_tester_slow(const PhaseResult& result) { return is_busy(result) || is_late(result.tally); }

std::vector<std::string> warnings_of(const LoadSettings& settings, const Outcome& outcome) {
  const PhaseResult& result = outcome.result;
  std::vector<std::string> out;
  for (const auto& [code, ended] : result.ended)
    out.push_back(std::to_string(ended.count) + " of " + std::to_string(settings.streams.count()) +
                  " streams ended early: " + code + ": " + ended.first);
  if (is_busy(result))
    out.push_back("the tester itself was slow: its busiest thread worked " +
                  format_double("%.0f", 100 * result.cost.busiest_thread) +
                  " % of the time; use more --workers, or more cores");
  if (is_late(result.tally))
    out.push_back("the tester itself was late: one frame in a hundred left " +
                  milliseconds_text(result.tally.delay.percentile(99)) +
                  " ms late or later; other work takes its cores");
  if (!outcome.daemon) return out;
  const Comparison comparison = compare(outcome.counted, *outcome.daemon);
  if (comparison.max_difference > kMaxDifference)
    out.push_back("the daemon's counters differ from the tester's by up to " +
                  format_double("%.2g", 100 * comparison.max_difference) +
                  " %: others use this daemon, or answers came after the end");
  return out;
}

Json outcome_json(const LoadSettings& settings, const Outcome& outcome) {
  const PhaseResult& result = outcome.result;
  Json out = {
      {"version", outcome.version}, {"host", outcome.host}, {"device", outcome.scene.device()}, {"date", outcome.date}};
  out.update({{"load", load_json(settings, outcome)}, {"input", input_json(outcome)}});
  if (settings.find_max.p99_ms > 0) out["find_max"] = search_json(settings, outcome);
  if (settings.streams.generations > 1) out["generations"] = generations_json(outcome);
  out["interrupted"] = result.is_interrupted;
  out["frames"] = frames_json(result.tally);
  out["refused"] = refusals_json(result.tally.refused);
  out["streams_ended"] = refusals_json(result.ended);
  out["throughput"] = throughput_json(result);
  out.update(measured_json(result.tally));
  out["tester"] = tester_json(outcome);
  if (outcome.daemon) {
    out["daemon_counters"] = daemon_json(*outcome.daemon);
    const Comparison comparison = compare(outcome.counted, *outcome.daemon);
    out["comparison"] = comparison.counts;
    out["comparison"]["max_difference_percent"] = 100 * comparison.max_difference;
  }
  out["warnings"] = warnings_of(settings, outcome);
  out["series"] = series_json(result.series);
  out["latency_curve"] = curve_json(result.tally.latency);
  out["service_curve"] = curve_json(result.tally.service);
  return out;
}

}  // namespace collided::cli::load
