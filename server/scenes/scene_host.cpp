// All scenes of the daemon and what watches over them.
#include "server/scenes/scene_host.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr auto kWatchPeriod = std::chrono::milliseconds(250);
constexpr uint64_t kWatchesOfMemory = 8;  // what is used again soon had better stay

// On a GPU the host's part of one frame goes on beside the device's part of another; on CPU cores two keep all busy
// while one of them is in a part that does not spread over cores. A step on a GPU gives no turn back before its end: a
// client that could hold all turns would stop the others for that long.
Turns::Options turn_options(const Config& config, const Now& now) {
  constexpr unsigned kOnGpu = 4, kOnCpu = 2;
  const bool on_gpu = config.backend != "cpu" && cuda_available();
  const unsigned by_itself = on_gpu ? kOnGpu : kOnCpu, asked = static_cast<unsigned>(config.concurrent_frames);
  return {.at_once = asked > 0 ? asked : by_itself, .keeps_one_free = on_gpu, .now = now};
}

}  // namespace

SceneHost::SceneHost(const Config& config, SceneObserver& observer, const Now& now)
    : now_(now),
      limits_(config.limits),
      turns_(turn_options(config, now)),
      usage_(config.limits, now),
      scenes_(config.limits.max_scenes, config.limits.max_window, {turns_, observer, config.endpoint, now}),
      watch_([this] { watch(); }) {}

SceneHost::~SceneHost() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
  watch_.join();
  scenes_.clear();
}

Limits SceneHost::limits() const {
  const std::lock_guard lock(mutex_);
  return limits_;
}

void SceneHost::set_limits(const Limits& limits) {
  usage_.set_limits(limits);
  scenes_.set_max_scenes(limits.max_scenes);
  scenes_.set_queue_capacity(limits.max_window);
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

SceneStore::Added SceneHost::add_scene(const Client& owner, SceneRequest request) {
  check_serving();
  request.plan.quota = usage_.device_bytes(owner);
  request.plan.quota->check_could_hold(request.plan.min_bytes, "the vertices and triangles of spec.meshes");
  return scenes_.add(owner, std::move(request));
}

void SceneHost::check_serving() const {
  if (stopping_) throw Stopping();
}

void SceneHost::announce_stop(double seconds) {
  stopping_ = true;
  for (const auto& scene : scenes_.all())
    if (const auto stream = scene->stream()) stream->announce_stop(seconds);
}

void SceneHost::end_streams() const {
  for (const auto& scene : scenes_.all())
    if (const auto stream = scene->stream()) stream->end(std::make_exception_ptr(Stopping()));
}

HostTotals SceneHost::totals() const {
  HostTotals totals;
  totals.streams = usage_.streams();
  totals.device_bytes = usage_.held_device_bytes();
  for (const auto& scene : scenes_.all()) {
    ++totals.scenes;
    if (const auto stream = scene->stream()) totals.waiting_frames += stream->waiting();
  }
  return totals;
}

void SceneHost::watch() {
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, kWatchPeriod, [this] { return is_over_; })) {
    lock.unlock();
    watch_once();
    lock.lock();
  }
}

void SceneHost::watch_once() {
  for (const auto& scene : scenes_.remove_expired(now_())) scene->observer().expired(*scene);
  end_idle_streams();
  end_stale_uploads();
  if (++watches_ % kWatchesOfMemory == 0) freed_.give_back();
}

void SceneHost::end_stale_uploads() {
  const Limits now = limits();
  const std::chrono::duration<double> most(std::min(now.max_silent_seconds, now.max_idle_seconds));
  uploads_.end_stale(Upload::Clock::now(), most);
}

void SceneHost::end_idle_streams() const {
  const double most = limits().max_idle_seconds;
  for (const auto& scene : scenes_.all()) {
    const auto stream = scene->stream();
    if (!stream || stream->idle_seconds() <= most) continue;
    const auto what = fmt::format("max_idle_seconds is {}, and for longer no frame came, or no answer was taken", most);
    stream->end(std::make_exception_ptr(LimitExceeded::quota("scene:" + scene->id(), what)));
  }
}

}  // namespace collided::server
