#pragma once
// Waits for another thread, without assumptions about its speed.

#include <chrono>
#include <thread>

namespace collided::server {

/// Waits until it holds; false after 30 s.
template <class Condition>
bool wait_until(const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace collided::server
