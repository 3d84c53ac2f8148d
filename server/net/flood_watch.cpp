// Looks for connections that flood.
#include "server/net/flood_watch.hpp"

#include <chrono>
#include <new>
#include <utility>

namespace collided::server {

FloodWatch::FloodWatch(Connections& connections, std::function<void(const EndedFlood& flood)> report)
    : connections_(connections), report_(std::move(report)), thread_([this] { run(); }) {}

FloodWatch::~FloodWatch() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  stopped_.notify_one();
  thread_.join();
}

void FloodWatch::run() {
  constexpr auto kPause = std::chrono::milliseconds(100);
  std::unique_lock lock(mutex_);
  while (!stopped_.wait_for(lock, kPause, [this] { return is_stopping_; })) look();
}

void FloodWatch::look() try {
  for (const EndedFlood& flood : connections_.end_floods()) report_(flood);
} catch (const std::bad_alloc&) {
  return;  // there is a next time
}

}  // namespace collided::server
