#pragma once
// Threads that wait for what only one of them can fetch at a time: whoever waits first fetches, for all. A thread that
// gets what it waits for by itself need not be woken up for it.

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace collided::client {

/// Guarded by the mutex of the lock that is passed, as everything that the threads wait for.
class Lead {
 public:
  using Lock = std::unique_lock<std::mutex>;
  using Time = std::chrono::steady_clock::time_point;

  /// Waits until `done()`, but not past `deadline`; whether it is done. `fetch(lock, deadline)` gives the lock away
  /// while it waits, and is false if nothing came until the deadline.
  template <class Done, class Fetch>
  bool await(Lock& lock, const Done& done, Time deadline, const Fetch& fetch) {
    bool is_in_time = true;
    while (!done() && is_in_time)
      is_in_time =
          is_taken_ ? changed_.wait_until(lock, deadline) == std::cv_status::no_timeout : take(lock, deadline, fetch);
    return done();
  }
  /// Fetches once, while nobody else does.
  template <class Fetch>
  bool take(Lock& lock, Time deadline, const Fetch& fetch) {
    is_taken_ = true;
    const bool is_fetched = fetch(lock, deadline);
    is_taken_ = false;
    notify();
    return is_fetched;
  }
  /// What threads wait for may have come in another way.
  void notify() { changed_.notify_all(); }

 private:
  std::condition_variable changed_;
  bool is_taken_ = false;
};

}  // namespace collided::client
