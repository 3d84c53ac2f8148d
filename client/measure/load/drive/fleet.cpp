// All streams.

#include "client/measure/load/drive/fleet.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <stdexcept>
#include <thread>

#include "client/cli/input/mesh_input.hpp"
#include "client/cli/output/progress.hpp"
#include "client/cpp/transport/grpc/channel.hpp"
#include "client/measure/load/drive/lane.hpp"

namespace collided::cli::load {

namespace {

using namespace std::chrono_literals;

constexpr auto kPoll = 10ms;
constexpr auto kStartDelay = 20ms;  // so that the first frames are not late
constexpr auto kOpenTimeout = 60s, kSettleTimeout = 60s, kFinishTimeout = 5s;
constexpr size_t kOpenedAtOnce = 64;  // more would wait for each other in the daemon's queues

uint32_t worker_count(const StreamSettings& streams) {
  constexpr uint32_t kMax = 4, kCoresEach = 4;
  const uint32_t fitting = std::clamp(std::thread::hardware_concurrency() / kCoresEach, 1U, kMax);
  return std::min(streams.workers ? streams.workers : fitting, streams.count());
}

double process_cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

client::ChannelFactory factory_of(const Target& target, const v1::Scene& scene) {
  return {scene.endpoint().empty() ? target.address() : scene.endpoint(), target.connect_options()};
}

v1::SceneSpec spec_of(const LoadSettings& settings, const Motion& motion) {
  v1::SceneSpec spec = scene_spec(settings.server, settings.detection, format_of(settings.input.position_format));
  spec.set_display_name("load: " + motion.name.substr(0, 100));
  return spec;
}

}  // namespace

struct Fleet::State {
  State(Target& target, const LoadSettings& settings, const Motion& motion)
      : settings(settings.streams), spec(spec_of(settings, motion)), messages(motion, spec) {
    scenes = target.create_scenes(spec, mesh_inputs(motion.meshes), settings.streams.count());
    for (uint32_t i = 0; i < worker_count(settings.streams); ++i) lanes.push_back(std::make_unique<Lane>(messages));
  }

  LaneState lane_state() const {
    LaneState sum;
    for (const auto& lane : lanes) sum += lane->state();
    return sum;
  }
  bool is_idle() const {
    return std::all_of(lanes.begin(), lanes.end(), [](const auto& lane) { return lane->is_idle(); });
  }
  double busiest_thread_seconds() const {
    double seconds = 0;
    for (const auto& lane : lanes) seconds = std::max(seconds, lane->busiest_thread_seconds());
    return seconds;
  }
  Second take_second() const {
    Second sum;
    for (const auto& lane : lanes) sum.add(lane->take_second());
    return sum;
  }
  Tally take_tally() const {
    Tally sum;
    for (const auto& lane : lanes) sum.add(lane->take_tally());
    return sum;
  }
  void open_streams(const Target& target);
  void await_open(size_t opened);

  const StreamSettings& settings;
  v1::SceneSpec spec;
  Messages messages;
  std::vector<std::shared_ptr<const SceneGuard>> scenes;
  std::vector<std::unique_ptr<Lane>> lanes;  // before the scenes are deleted, their streams end
  size_t connections = 0;
};

void Fleet::State::open_streams(const Target& target) {
  const client::ChannelFactory factory = factory_of(target, **scenes.front());
  std::shared_ptr<grpc::Channel> channel;
  Progress progress;
  for (uint32_t i = 0; i < scenes.size(); ++i) {
    if (!settings.shares_connections || i % settings.scenes == 0) {
      channel = factory.make();
      ++connections;
    }
    v1::OpenStream open;
    open.set_scene_id((*scenes[i])->scene_id());
    open.set_window(settings.window);
    if (settings.latest_wins) open.set_delivery(v1::DELIVERY_POLICY_LATEST_WINS);
    const StreamPlace place{i, static_cast<uint32_t>(scenes.size())};
    lanes[i % lanes.size()]->open(channel, factory.context(open.scene_id()), open, place);
    const bool is_batch_full = (i + 1) % kOpenedAtOnce == 0 || i + 1 == scenes.size();
    if (is_batch_full) await_open(i + 1);
    progress.show("streams", static_cast<int>(i) + 1, static_cast<int>(scenes.size()));
  }
}

void Fleet::State::await_open(size_t opened) {
  const Time deadline = Clock::now() + kOpenTimeout;
  for (;;) {
    check_interrupt();
    const LaneState now = lane_state();
    if (now.ended > 0) {
      const auto& [code, refusals] = *now.ends.begin();
      throw std::runtime_error("stream " + std::to_string(now.open + 1) + " of " + std::to_string(scenes.size()) +
                               " was not opened: " + code + ": " + refusals.first);
    }
    if (now.open == opened) return;
    if (Clock::now() > deadline)
      throw std::runtime_error("only " + std::to_string(now.open) + " of " + std::to_string(scenes.size()) +
                               " streams were opened within a minute; does the daemon's --max-connections allow " +
                               std::to_string(connections) + "?");
    std::this_thread::sleep_for(kPoll);
  }
}

Fleet::Fleet(Target& target, const LoadSettings& settings, const Motion& motion)
    : state_(std::make_unique<State>(target, settings, motion)) {
  state_->open_streams(target);
}

Fleet::~Fleet() = default;

const v1::Scene& Fleet::scene() const { return **state_->scenes.front(); }
uint64_t Fleet::bytes_per_frame() const { return state_->messages.bytes(); }
size_t Fleet::connections() const { return state_->connections; }
size_t Fleet::threads() const { return 2 * state_->lanes.size(); }

namespace {

/// Follows a phase second by second.
class Watch {
 public:
  Watch(Time start, const Fleet::OnSecond& on_second, PhaseResult& result)
      : start_(start), on_second_(on_second), result_(result) {}

  bool is_over() const { return Clock::now() >= start_ + std::chrono::seconds(result_.series.size() + 1); }
  void close_second(const Second& second) {
    const double at = std::min(ms_between(start_, Clock::now()) / 1000, result_.series.size() + 1.0);
    result_.series.push_back(point_of(at, second));
    if (on_second_) on_second_(result_.series.back());
  }

 private:
  const Time start_;
  const Fleet::OnSecond& on_second_;
  PhaseResult& result_;
};

}  // namespace

PhaseResult Fleet::run(const PhasePlan& plan, const OnSecond& on_second) {
  const auto seconds_of = [](double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  };
  PhaseResult result;
  state_->take_tally();
  state_->take_second();
  const double cpu_before = process_cpu_seconds(), thread_before = state_->busiest_thread_seconds();
  Phase phase{
      .start = Clock::now() + kStartDelay, .profile = plan.profile, .arrivals = plan.arrivals, .seed = plan.seed};
  if (plan.max_frames > 0) phase.max_frames = plan.max_frames;
  const Time end =
      plan.max_frames > 0 ? kNever : phase.start + seconds_of(plan.profile ? plan.profile->seconds() : plan.seconds);
  for (const auto& lane : state_->lanes) lane->begin(phase);
  Watch watch(phase.start, on_second, result);
  bool is_stopped = plan.max_frames > 0;
  for (Time now = Clock::now(); !(is_stopped && state_->is_idle()); now = Clock::now()) {
    const LaneState streams = state_->lane_state();
    result.is_interrupted = is_interrupted();
    if (result.is_interrupted || streams.open == 0) break;
    if (end != kNever && now > end + seconds_of(plan.drain_seconds)) break;
    if (now >= end && !std::exchange(is_stopped, true) && !plan.profile)
      for (const auto& lane : state_->lanes) lane->stop();
    if (watch.is_over()) watch.close_second(state_->take_second());
    std::this_thread::sleep_for(kPoll);
  }
  const Time stopped = Clock::now();
  for (const auto& lane : state_->lanes) lane->give_up(stopped);
  result.seconds = ms_between(phase.start, stopped) / 1000;
  watch.close_second(state_->take_second());
  result.tally = state_->take_tally();
  result.cost = {.cpu_seconds = process_cpu_seconds() - cpu_before,
                 .busiest_thread = (state_->busiest_thread_seconds() - thread_before) / result.seconds};
  result.ended = state_->lane_state().ends;
  return result;
}

bool Fleet::settle() {
  const Time deadline = Clock::now() + kSettleTimeout;
  for (; !state_->is_idle(); std::this_thread::sleep_for(kPoll))
    if (is_interrupted() || Clock::now() > deadline) return false;
  return true;
}

void Fleet::finish() {
  for (const auto& lane : state_->lanes) lane->finish();
  const Time deadline = Clock::now() + kFinishTimeout;
  const auto is_done = [&] { return state_->lane_state().open == 0; };
  while (!is_done() && !is_interrupted() && Clock::now() < deadline) std::this_thread::sleep_for(kPoll);
  state_->lanes.clear();
  state_->scenes.clear();
}

}  // namespace collided::cli::load
