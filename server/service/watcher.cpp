// One watcher of a scene.
#include "server/service/watcher.hpp"

#include <utility>

namespace collided::server {

void Watcher::answered(const std::shared_ptr<const WatchedFrame>& frame) {
  {
    const std::lock_guard lock(mutex_);
    if (is_closed_) return;
    latest_ = frame;
    ++unseen_;
    if (!is_due_locked()) return;
  }
  show_latest();
}

// Only the worker may read positions, and between frames they are those of the latest one.
void Watcher::ready() {
  {
    const std::lock_guard lock(mutex_);
    is_ready_ = !is_closed_;
    if (!is_due_locked()) return;
  }
  scene_->worker().post([self = shared_from_this()] { self->show_latest(); });
}

void Watcher::taken() {
  const std::lock_guard lock(mutex_);
  unread_since_.reset();
}

void Watcher::show_latest() try {
  auto update = take_latest();
  const auto sink = sink_.lock();
  if (!update || !sink) return;
  follow_edits(*sink);
  for (const VertexSample& sample : samples_.of_mesh) update->positions.push_back(scene_->engine().positions(sample));
  update->vertex_stride = samples_.stride;
  if (update->skipped > 0) scene_->observer().counted(*scene_, CounterId::kNotShownFrames, update->skipped);
  sink->show(std::move(*update));
} catch (...) {
  end(std::current_exception());
}

// Between frames the scene's meshes are those of the latest one.
void Watcher::follow_edits(WatchSink& sink) {
  const auto plan = scene_->plan();
  if (plan == plan_) return;
  samples_ = samples_after_edit(options_, *plan);
  sink.reserve(max_watch_message_bytes(options_, samples_, *plan));
  plan_ = plan;
}

std::optional<WatchedUpdate> Watcher::take_latest() {
  const std::lock_guard lock(mutex_);
  if (!is_due_locked()) return std::nullopt;
  is_ready_ = false;
  unread_since_ = scene_->now();
  WatchedUpdate update;
  update.frame = std::exchange(latest_, nullptr);
  update.skipped = std::exchange(unseen_, 0) - 1;
  return update;
}

bool Watcher::leave() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(is_closed_, true)) return false;
    is_ready_ = false;
    latest_.reset();
    unread_since_.reset();
  }
  scene_->record().end_watch(*this);
  return true;
}

void Watcher::end(const std::exception_ptr& why) {
  if (!leave()) return;
  if (const auto sink = sink_.lock()) sink->ended(why);
}

double Watcher::unread_seconds() const {
  const std::lock_guard lock(mutex_);
  return unread_since_ ? seconds_between(*unread_since_, scene_->now()) : 0;
}

}  // namespace collided::server
