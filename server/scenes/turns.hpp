#pragma once
// Whose frame runs next where several scenes share a device: of those that wait, the scene that has had the least time.
// No gRPC here.

#include <condition_variable>
#include <functional>
#include <list>
#include <mutex>

namespace collided::server {

/// A scene's share: the time that it has had, in seconds. A scene that was idle does not save up its turns.
class TurnAccount {
  friend class Turns;
  double used_ = 0;
};

class Turns {
 public:
  /// `at_once`: frames of different scenes that run beside each other, 1 or more.
  explicit Turns(unsigned at_once) : free_(at_once) {}

  /// A turn lasts as long as this, and is charged to its account at the end.
  class Turn {
   public:
    Turn(Turn&& other) noexcept : turns_(other.turns_), account_(other.account_), start_(other.start_) {
      other.turns_ = nullptr;
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn();

   private:
    friend class Turns;
    Turn(Turns* turns, TurnAccount* account);
    Turns* turns_;
    TurnAccount* account_;
    double start_;
  };

  /// Waits for a turn. An account waits for one at a time. Throws Cancelled soon after `cancelled` turns true.
  Turn take(TurnAccount& account, const std::function<bool()>& cancelled = {});

 private:
  struct Waiter {
    TurnAccount* account;
    std::condition_variable called;
  };

  bool is_next(const Waiter& waiter) const;
  void call_next();
  void end(TurnAccount& account, double seconds);

  std::mutex mutex_;
  std::list<Waiter*> waiting_;
  unsigned free_;
  double now_ = 0;  ///< what the account of the last turn had used at its begin
};

}  // namespace collided::server
