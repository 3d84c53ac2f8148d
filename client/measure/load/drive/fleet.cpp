// All streams.

#include "client/measure/load/drive/fleet.hpp"

#include <algorithm>
#include <stdexcept>
#include <thread>

#include "client/app/input/mesh_input.hpp"
#include "client/app/output/progress.hpp"
#include "client/cpp/transport/grpc/channel.hpp"
#include "client/measure/load/drive/lane.hpp"

namespace collided::cli::load {

namespace {

using namespace std::chrono_literals;

constexpr auto kPoll = 10ms;
constexpr auto kOpenTimeout = 60s, kFinishTimeout = 5s;
constexpr size_t kOpenedAtOnce = 64;  // more would wait for each other in the daemon's queues

uint32_t worker_count(const StreamSettings& streams) {
  constexpr uint32_t kMax = 4, kCoresEach = 4;
  const uint32_t fitting = std::clamp(std::thread::hardware_concurrency() / kCoresEach, 1U, kMax);
  return std::min(streams.workers ? streams.workers : fitting, streams.count());
}

v1::SceneSpec spec_of(const LoadSettings& settings, const Motion& motion) {
  v1::SceneSpec spec = scene_spec(settings.server, settings.detection, format_of(settings.input.position_format));
  spec.set_display_name("load");
  for (int i = 0; i < motion.frames; ++i) grow_box(spec, motion.positions(i));
  return spec;
}

}  // namespace

struct Fleet::State {
  State(Target& target, const LoadSettings& settings, const Motion& motion)
      : streams(settings.streams), spec(spec_of(settings, motion)), messages(motion, spec) {
    scenes = target.create_scenes(spec, mesh_inputs(motion.meshes), streams.count());
    for (uint32_t i = 0; i < worker_count(streams); ++i) lanes.push_back(std::make_unique<Lane>(messages));
  }

  template <class Sum, class Part>
  Sum sum(const Part& part) const {
    Sum all;
    for (const auto& lane : lanes) all += part(*lane);
    return all;
  }
  void open_streams(const Target& target);
  void await_open(size_t opened);

  const StreamSettings streams;
  const v1::SceneSpec spec;
  const Messages messages;
  std::vector<std::shared_ptr<const SceneGuard>> scenes;
  std::vector<std::unique_ptr<Lane>> lanes;  // after the scenes: streams end before their scenes are deleted
  size_t connections = 0;
};

void Fleet::State::open_streams(const Target& target) {
  const std::string& endpoint = (*scenes.front())->endpoint();
  const client::ChannelFactory channels(endpoint.empty() ? target.address() : endpoint, target.connect_options());
  std::shared_ptr<grpc::Channel> channel;
  Progress progress;
  const auto count = static_cast<uint32_t>(scenes.size());
  for (uint32_t i = 0; i < count; ++i) {
    if (!streams.shares_connections || i % streams.scenes == 0) {
      channel = channels.make();
      ++connections;
    }
    v1::OpenStream open;
    open.set_scene_id((*scenes[i])->scene_id());
    open.set_window(streams.window);
    if (streams.latest_wins) open.set_delivery(v1::DELIVERY_POLICY_LATEST_WINS);
    lanes[i % lanes.size()]->open(channel, channels.context(open.scene_id()), open, {i, count});
    if ((i + 1) % kOpenedAtOnce == 0 || i + 1 == count) await_open(i + 1);
    progress.show("streams", static_cast<int>(i) + 1, static_cast<int>(count));
  }
}

void Fleet::State::await_open(size_t opened) {
  const std::string of_all = " of " + std::to_string(scenes.size());
  for (const Time deadline = Clock::now() + kOpenTimeout;; std::this_thread::sleep_for(kPoll)) {
    check_interrupt();
    const auto now = sum<StreamStates>([](Lane& lane) { return lane.states(); });
    if (now.open == opened) return;
    const std::string next = "stream " + std::to_string(now.open + 1) + of_all + " was not opened";
    if (now.ended > 0)
      throw std::runtime_error(next + ": " + now.ends.begin()->first + ": " + now.ends.begin()->second.first);
    if (Clock::now() > deadline)
      throw std::runtime_error(next + " within a minute; does --max-connections of the daemon allow " +
                               std::to_string(connections) + "?");
  }
}

Fleet::Fleet(Target& target, const LoadSettings& settings, const Motion& motion)
    : state_(std::make_unique<State>(target, settings, motion)) {
  state_->open_streams(target);
}

Fleet::~Fleet() = default;

const v1::Scene& Fleet::scene() const { return **state_->scenes.front(); }
uint32_t Fleet::stream_count() const { return state_->streams.count(); }
uint64_t Fleet::bytes_per_frame() const { return state_->messages.bytes(); }
size_t Fleet::connections() const { return state_->connections; }
size_t Fleet::threads() const { return Lane::kThreads * state_->lanes.size(); }

void Fleet::begin(const Phase& phase) {
  for (const auto& lane : state_->lanes) lane->begin(phase);
}

void Fleet::stop() {
  for (const auto& lane : state_->lanes) lane->stop();
}

bool Fleet::is_idle() const {
  return std::all_of(state_->lanes.begin(), state_->lanes.end(), [](const auto& lane) { return lane->is_idle(); });
}

void Fleet::give_up(Time now) {
  for (const auto& lane : state_->lanes) lane->give_up(now);
}

StreamStates Fleet::states() const {
  return state_->sum<StreamStates>([](Lane& lane) { return lane.states(); });
}

Tally Fleet::take_tally() {
  return state_->sum<Tally>([](Lane& lane) { return lane.take_tally(); });
}

Second Fleet::take_second() {
  return state_->sum<Second>([](Lane& lane) { return lane.take_second(); });
}

double Fleet::busiest_thread_seconds() const {
  double seconds = 0;
  for (const auto& lane : state_->lanes) seconds = std::max(seconds, lane->busiest_thread_seconds());
  return seconds;
}

void Fleet::finish() {
  for (const auto& lane : state_->lanes) lane->finish();
  for (const Time deadline = Clock::now() + kFinishTimeout;
       states().open > 0 && !is_interrupted() && Clock::now() < deadline;)
    std::this_thread::sleep_for(kPoll);
  state_->lanes.clear();
  state_->scenes.clear();
}

}  // namespace collided::cli::load
