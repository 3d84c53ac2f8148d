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
  if (!update) return;
  for (const VertexSample& sample : options_.samples) update->positions.push_back(scene_->positions(sample));
  if (update->skipped > 0) scene_->observer().not_shown(*scene_, update->skipped);
  if (const auto sink = sink_.lock()) sink->show(std::move(*update));
} catch (...) {
  end(std::current_exception());
}

std::optional<WatchedUpdate> Watcher::take_latest() {
  const std::lock_guard lock(mutex_);
  if (!is_due_locked()) return std::nullopt;
  is_ready_ = false;
  unread_since_ = scene_->now();
  return WatchedUpdate{std::exchange(latest_, nullptr), {}, std::exchange(unseen_, 0) - 1};
}

bool Watcher::leave() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(is_closed_, true)) return false;
    is_ready_ = false;
    latest_.reset();
    unread_since_.reset();
  }
  scene_->end_watch(*this);
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
