// All scenes of the daemon: limits, leases, idle streams, fair turns.
#include "server/scenes/scene_host.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr auto kWatchPeriod = std::chrono::milliseconds(250);
constexpr uint64_t kWatchesPerTrim = 8;  // trimming memory that is soon reused would be wasted

}  // namespace

SceneHost::SceneHost(const Config& config, SceneObserver& observer, const Now& now)
    : now_(now),
      limits_(config.limits),
      devices_(devices_at_start(config, now), now),
      usage_(config.limits, now),
      scenes_(config.limits.max_scenes, config.limits.max_window,
              {devices_, observer, config.endpoint, now, config.name}),
      freed_(config.gives_back_memory ? std::optional<FreedMemory>(std::in_place) : std::nullopt),
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
  devices_.set_limits(limits);
  scenes_.set_max_scenes(limits.max_scenes);
  scenes_.set_queue_capacity(limits.max_window);
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

SceneStore::Added SceneHost::add_scene(const Client& owner, SceneRequest request) {
  check_could_add(owner, request.plan);
  request.plan.quota = usage_.device_bytes(owner);
  request.plan.engine.known = usage_.known_lengths(owner);
  return scenes_.add(owner, std::move(request));
}

void SceneHost::check_could_add(const Client& owner, const ScenePlan& plan) {
  check_serving();
  usage_.device_bytes(owner)->check_could_hold(plan.min_bytes, "the vertices and triangles of spec.meshes");
  devices_.check_could_hold(wish_of(plan));
}

void SceneHost::check_serving() const {
  if (stopping_) throw Stopping();
}

void SceneHost::announce_stop(double seconds) {
  grace_seconds_ = seconds;
  stopping_ = true;
  for (const auto& scene : scenes_.all())
    if (const auto stream = scene->record().stream()) stream->announce_stop(seconds);
}

void SceneHost::tell_of_stop(SceneStream& stream) const {
  if (ended_) throw Stopping();
  if (stopping_) stream.announce_stop(grace_seconds_);
}

void SceneHost::end_streams() {
  ended_ = true;
  const auto why = std::make_exception_ptr(Stopping());
  for (const auto& scene : scenes_.all()) {
    if (const auto stream = scene->record().stream()) stream->end(why);
    for (const auto& watcher : scene->record().watchers().all()) watcher->end(why);
  }
}

HostTotals SceneHost::totals() const {
  HostTotals totals;
  totals.streams = usage_.streams();
  totals.device_bytes = usage_.held_device_bytes();
  totals.devices = devices_.state();
  for (const auto& scene : scenes_.all()) {
    ++totals.scenes;
    totals.watchers += scene->record().watchers().size();
    if (const auto stream = scene->record().stream()) totals.waiting_frames += stream->waiting();
  }
  for (const DeviceState& device : totals.devices) totals.waiting_frames += device.waiting_frames;
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
  end_unread_watches();
  end_stale_uploads();
  if (freed_ && ++watches_ % kWatchesPerTrim == 0) freed_->give_back();
}

void SceneHost::end_stale_uploads() {
  const Limits now = limits();
  const std::chrono::duration<double> limit(std::min(now.max_silent_seconds, now.max_idle_seconds));
  uploads_.end_stale(Upload::Clock::now(), limit);
}

void SceneHost::end_idle_streams() const {
  const double limit = limits().max_idle_seconds;
  for (const auto& scene : scenes_.all()) {
    const auto stream = scene->record().stream();
    if (!stream || stream->idle_seconds() <= limit) continue;
    const auto what =
        fmt::format("max_idle_seconds is {}, and for longer no frame arrived, or no answer was taken", limit);
    stream->end(std::make_exception_ptr(LimitExceeded::quota("scene:" + scene->id(), what)));
  }
}

void SceneHost::end_unread_watches() const {
  const double limit = limits().max_idle_seconds;
  for (const auto& scene : scenes_.all())
    for (const auto& watcher : scene->record().watchers().all())
      if (watcher->unread_seconds() > limit)
        watcher->end(std::make_exception_ptr(LimitExceeded::quota(
            "scene:" + scene->id(),
            fmt::format("max_idle_seconds is {}, and the watcher left a message unread for longer", limit))));
}

}  // namespace collided::server
