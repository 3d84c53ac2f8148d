// collidectl load: the order of its steps.

#include "client/measure/load/run.hpp"

#include <unistd.h>

#include <algorithm>
#include <climits>
#include <cstdio>
#include <ctime>
#include <exception>
#include <stdexcept>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/output/output.hpp"
#include "client/app/report/text.hpp"
#include "client/measure/load/daemon/limits.hpp"
#include "client/measure/load/drive/fleet.hpp"
#include "client/measure/load/drive/phase_run.hpp"
#include "client/measure/load/report/html.hpp"
#include "client/measure/load/report/outcome.hpp"
#include "client/measure/load/report/text.hpp"
#include "client/measure/load/search.hpp"

namespace collided::cli::load {

namespace {

constexpr double kTrialDrainSeconds = 1;  // or the bound itself: until then nothing is too late

/// A line for each second; the rest of one at the end is too short to say anything.
void show(const SeriesPoint& point) {
  constexpr double kWorthALine = 0.5;
  if (point.end - point.begin >= kWorthALine) std::fprintf(stderr, "%s\n", second_text(point).c_str());
}

/// Why a trial did not hold; empty if it did.
std::string failure_of(const PhaseResult& result, double p99_ms) {
  const Tally& tally = result.tally;
  if (!result.ended.empty()) return "streams ended";
  if (tally.refused_count() > 0) return std::to_string(tally.refused_count()) + " refused";
  if (tally.skipped > 0) return std::to_string(tally.skipped) + " skipped";
  if (tally.unanswered + tally.unsent > 0) return std::to_string(tally.unanswered + tally.unsent) + " not answered";
  if (tally.answered == 0) return "no frame was due";
  if (tally.latency.percentile(99) <= p99_ms) return "";
  return is_tester_slow(result) ? "p99 too high, but the tester itself was slow" : "p99 too high";
}

Trial trial_of(double rate, const PhaseResult& result, double p99_ms) {
  const Histogram& latency = result.tally.latency;
  return {.rate = rate,
          .failure = failure_of(result, p99_ms),
          .p50 = latency.percentile(50),
          .p99 = latency.percentile(99),
          .max = latency.max(),
          .answered = result.tally.answered};
}

void show(const Trial& trial) {
  std::fprintf(stderr, "trial: %.6g frames/s, p99 %.4g ms: %s\n", trial.rate, trial.p99,
               trial.failure.empty() ? "held" : trial.failure.c_str());
}

/// Takes the result of the best trial or, while none has held, of the last; and how the last one ended.
void keep(Outcome& outcome, PhaseResult result, bool is_better) {
  outcome.counted += result.tally;
  const bool is_interrupted = result.is_interrupted;
  RefusalsByCode ended = result.ended;
  if (is_better) outcome.result = std::move(result);
  outcome.result.is_interrupted = is_interrupted;
  outcome.result.ended = std::move(ended);
}

void find_max(Fleet& fleet, const LoadSettings& settings, Outcome& outcome) {
  const FindMaxSettings& wanted = settings.find_max;
  const double streams = settings.streams.count();
  RateSearch search(wanted.from > 0 ? wanted.from : 10 * streams, wanted.precision);
  while (const auto rate = search.next()) {
    const RateProfile profile(*rate / streams, wanted.trial_seconds);
    PhaseResult result = run_phase(fleet, {.profile = &profile,
                                           .arrivals = settings.pace.arrivals,
                                           .seed = settings.pace.seed,
                                           .drain_seconds = std::max(kTrialDrainSeconds, wanted.p99_ms / 1000)});
    const Trial trial = trial_of(*rate, result, wanted.p99_ms);
    const bool held = trial.failure.empty(), is_over = result.is_interrupted || !result.ended.empty();
    keep(outcome, std::move(result), !search.best() || (held && !is_over));
    if (is_over) break;
    show(trial);
    outcome.trials.push_back(trial);
    search.report(held);
    if (!settle(fleet)) break;
    outcome.counted += fleet.take_tally();
  }
  outcome.best = search.best();
}

void run_once(Fleet& fleet, const LoadSettings& settings, Outcome& outcome) {
  const PaceSettings& pace = settings.pace;
  outcome.result = run_phase(fleet,
                             {.profile = pace.profile ? &*pace.profile : nullptr,
                              .arrivals = pace.arrivals,
                              .seed = pace.seed,
                              .seconds = pace.seconds,
                              .drain_seconds = pace.drain_seconds},
                             [](const SeriesPoint& point) { show(point); });
  outcome.counted += outcome.result.tally;
}

/// What was measured is reported even if the daemon can no longer be asked.
void add_counters(Outcome& outcome, const Samples& before, const Target& target) {
  try {
    outcome.daemon = growth(before, *target.samples());
  } catch (const std::runtime_error& e) {
    std::fprintf(stderr, "warning: %s\n", e.what());
  }
}

Outcome measure(Target& target, Fleet& fleet, const LoadSettings& settings) {
  Outcome outcome;
  outcome.scene = fleet.scene();
  outcome.bytes_per_frame = fleet.bytes_per_frame();
  outcome.connections = fleet.connections();
  outcome.threads = fleet.threads();
  warm_up(fleet, settings.streams.warm_up);
  const auto before = target.samples();
  if (settings.find_max.p99_ms > 0)
    find_max(fleet, settings, outcome);
  else
    run_once(fleet, settings, outcome);
  if (before) add_counters(outcome, *before, target);
  return outcome;
}

/// Ends after a generation that was interrupted or lost streams. What was measured is in the outcome even if it throws.
void run_generations(Target& target, const LoadSettings& settings, const Motion& motion, Outcome& outcome) {
  std::vector<Generation> generations;
  const uint32_t count = settings.streams.generations;
  do {
    const Time begin = Clock::now();
    Fleet fleet(target, settings, motion);
    const std::chrono::duration<double> setup = Clock::now() - begin;
    outcome = measure(target, fleet, settings);
    const Histogram& latency = outcome.result.tally.latency;
    generations.push_back({.setup_seconds = setup.count(),
                           .p50 = latency.percentile(50),
                           .p99 = latency.percentile(99),
                           .max = latency.max(),
                           .answered = outcome.result.tally.answered});
    outcome.generations = generations;
    fleet.finish();
  } while (generations.size() < count && !outcome.result.is_interrupted && outcome.result.ended.empty());
}

void warn_of_rate(const LoadSettings& settings, const v1::ServerLimits& limits) {
  if (!settings.pace.profile) return;
  const std::string warning = rate_warning(limits, settings.pace.profile->max_rate() * settings.streams.count());
  if (!warning.empty()) std::fprintf(stderr, "warning: %s\n", warning.c_str());
}

void write_files(const LoadSettings& settings, const Json& json) {
  if (!settings.out.empty()) write_text(settings.out, json_lines(json));
  if (!settings.html.empty()) write_text(settings.html, outcome_html(json));
}

/// Prints the result even if its files cannot be written.
void report(const LoadSettings& settings, const Outcome& outcome) {
  const Json json = outcome_json(settings, outcome);
  const std::exception_ptr failure = failure_in([&] { write_files(settings, json); });
  if (settings.json)
    std::printf("%s\n", json_text(json).c_str());
  else
    print_summary(settings.out, outcome_text(json));
  if (failure) std::rethrow_exception(failure);
}

std::string host_name() {
  char name[HOST_NAME_MAX + 1] = "";
  return gethostname(name, sizeof name) == 0 ? shown_name(name) : "unknown";
}

/// UTC in ISO 8601.
std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[sizeof "2026-01-01T00:00:00Z"];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace

void run_load(const LoadSettings& settings) {
  const Motion motion = make_motion(settings.input);
  Target target(settings);
  const v1::GetServerInfoResponse daemon = target.client().server_info();
  warn_of_rate(settings, daemon.limits());
  defer_interrupts();
  Outcome outcome;
  const std::exception_ptr failure = failure_in([&] { run_generations(target, settings, motion, outcome); });
  if (outcome.generations.empty() && failure) std::rethrow_exception(failure);
  outcome.input = motion.name;
  outcome.version = daemon.version();
  outcome.host = host_name();
  outcome.date = now_text();
  report(settings, outcome);
  if (outcome.result.is_interrupted) check_interrupt();
  if (failure) std::rethrow_exception(failure);
  if (!outcome.result.ended.empty()) throw std::runtime_error(warnings_of(settings, outcome).front());
}

}  // namespace collided::cli::load
