// One phase of a run.

#include "client/measure/load/drive/phase_run.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <stdexcept>
#include <thread>
#include <utility>

#include "client/app/daemon/interrupt.hpp"
#include "client/measure/load/drive/fleet.hpp"

namespace collided::cli::load {

namespace {

using namespace std::chrono_literals;

constexpr auto kPoll = 10ms;
constexpr auto kStartDelay = 20ms;  // so that the first frames are not late
constexpr auto kSettleTimeout = 60s;
constexpr uint32_t kWarmedAtOnce = 64;  // more would only wait for each other

double process_cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

class PhaseRun {
 public:
  PhaseRun(Fleet& fleet, const PhasePlan& plan, const OnSecond& on_second)
      : fleet_(fleet), plan_(plan), on_second_(on_second), start_(Clock::now() + kStartDelay) {}

  PhaseResult run();

 private:
  Time end() const { return start_ + seconds_of(plan_.profile ? plan_.profile->seconds() : plan_.seconds); }
  bool is_over(Time now);
  void close_second(Time now);

  Fleet& fleet_;
  const PhasePlan& plan_;
  const OnSecond& on_second_;
  const Time start_;
  bool is_past_end_ = false;
  PhaseResult result_;
};

PhaseResult PhaseRun::run() {
  fleet_.take_tally();
  fleet_.take_second();
  const double cpu_before = process_cpu_seconds(), thread_before = fleet_.busiest_thread_seconds();
  fleet_.begin({.start = start_, .profile = plan_.profile, .arrivals = plan_.arrivals, .seed = plan_.seed});
  for (Time now = Clock::now(); !is_over(now); now = Clock::now()) {
    if (ms_between(start_, now) >= 1000.0 * static_cast<double>(result_.series.size() + 1)) close_second(now);
    std::this_thread::sleep_for(kPoll);
  }
  const Time now = Clock::now();
  fleet_.give_up(now);
  close_second(now);
  result_.seconds = ms_between(start_, now) / 1000;
  result_.tally = fleet_.take_tally();
  result_.cost = {.cpu_seconds = process_cpu_seconds() - cpu_before,
                  .busiest_thread = (fleet_.busiest_thread_seconds() - thread_before) / result_.seconds};
  return std::move(result_);
}

bool PhaseRun::is_over(Time now) {
  const StreamStates streams = fleet_.states();
  result_.ended = streams.ends;
  result_.is_interrupted = is_interrupted();
  if (result_.is_interrupted || streams.open == 0) return true;
  if (now < end()) return false;
  if (!std::exchange(is_past_end_, true) && !plan_.profile) fleet_.stop();
  return fleet_.is_idle() || now > end() + seconds_of(plan_.drain_seconds);
}

void PhaseRun::close_second(Time now) {
  const double end = ms_between(start_, now) / 1000, begin = result_.series.empty() ? 0 : result_.series.back().end;
  result_.series.push_back(point_of(begin, end, fleet_.take_second()));
  if (on_second_) on_second_(result_.series.back());
}

}  // namespace

PhaseResult run_phase(Fleet& fleet, const PhasePlan& plan, const OnSecond& on_second) {
  return PhaseRun(fleet, plan, on_second).run();
}

void warm_up(Fleet& fleet, uint32_t frames) {
  fleet.take_tally();
  for (uint32_t first = 0; frames > 0 && first < fleet.stream_count(); first += kWarmedAtOnce) {
    fleet.begin(
        {.start = Clock::now(), .max_frames = frames, .first_stream = first, .end_stream = first + kWarmedAtOnce});
    if (!settle(fleet)) {
      check_interrupt();
      throw std::runtime_error("the daemon did not answer the first frames within a minute");
    }
    for (const auto& [code, refusals] : fleet.take_tally().refused)
      throw std::runtime_error("the daemon refused a first frame: " + code + ": " + refusals.first);
  }
}

bool settle(const Fleet& fleet) {
  const Time deadline = Clock::now() + kSettleTimeout;
  for (; !fleet.is_idle(); std::this_thread::sleep_for(kPoll))
    if (is_interrupted() || Clock::now() > deadline) return false;
  return true;
}

}  // namespace collided::cli::load
