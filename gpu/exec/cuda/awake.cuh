#pragma once
// Who waits for a GPU awake: a look at the memory that an answer comes to costs nothing but the core. Where many wait,
// the others sleep between their looks, for the cores have frames to receive and to send.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace collided {

/// While it lives, the calling thread waits.
class Awake {
 public:
  Awake() : is_awake_(waiting_.fetch_add(1, std::memory_order_relaxed) < most()) {}
  Awake(const Awake&) = delete;
  Awake& operator=(const Awake&) = delete;
  ~Awake() { waiting_.fetch_sub(1, std::memory_order_relaxed); }

  /// Between two looks; `look` is their number.
  void rest(unsigned look) const {
    if (!is_awake_)
      std::this_thread::sleep_for(kNap);
    else if (look % 16 == 0)
      std::this_thread::yield();
  }

 private:
  static constexpr std::chrono::microseconds kNap{20};
  /// A quarter of the cores.
  static unsigned most() {
    static const unsigned most = std::max(1u, std::thread::hardware_concurrency() / 4);
    return most;
  }
  inline static std::atomic<unsigned> waiting_{0};
  const bool is_awake_;
};

}  // namespace collided
