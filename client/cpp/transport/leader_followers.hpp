#pragma once
// Threads that wait for what only one of them can fetch at a time. One waiter fetches for everyone (leader/followers):
// a thread that fetches its own answer need not be woken for it.

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace collided::client {

/// Guarded by the mutex of the lock passed in, like everything that the threads wait for.
class LeaderFollowers {
 public:
  using Lock = std::unique_lock<std::mutex>;
  using Time = std::chrono::steady_clock::time_point;

  /// Waits until `done()`, but not past `deadline`, whatever else comes meanwhile; returns whether it is done.
  /// `fetch(lock, deadline)` releases the lock while it waits, and returns false if nothing came by the deadline.
  template <class Done, class Fetch>
  bool await(Lock& lock, const Done& done, Time deadline, const Fetch& fetch) {
    bool is_in_time = true;
    for (bool is_first = true; !done() && is_in_time; is_first = false) {
      if (!is_first && deadline != Time::max() && std::chrono::steady_clock::now() >= deadline) break;
      is_in_time = has_leader_ ? changed_.wait_until(lock, deadline) == std::cv_status::no_timeout
                               : lead_once(lock, deadline, fetch);
    }
    return done();
  }
  /// Fetches once. There must be no leader.
  template <class Fetch>
  bool lead_once(Lock& lock, Time deadline, const Fetch& fetch) {
    has_leader_ = true;
    const bool is_fetched = fetch(lock, deadline);
    has_leader_ = false;
    notify();
    return is_fetched;
  }
  /// Wakes the followers: what they wait for may have happened without a fetch.
  void notify() { changed_.notify_all(); }

 private:
  std::condition_variable changed_;
  bool has_leader_ = false;
};

}  // namespace collided::client
