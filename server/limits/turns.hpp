#pragma once
// Whose frame runs next when many scenes share a device: start-time fair queuing on two levels. Of the waiting clients,
// the one that has had the least time; of its scenes, the one that has had the least. No gRPC here.

#include <condition_variable>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/ops/clock.hpp"

namespace collided::server {

/// The time that the scenes of one client have had together.
class TurnClient {
  friend class Turns;
  double used_ = 0;          // seconds
  double virtual_time_ = 0;  // a scene that was idle counts as having had at least this
  unsigned running_ = 0;     // turns
};

/// The time that a scene has had. Neither a scene nor a client saves up time while idle.
class TurnAccount {
 public:
  explicit TurnAccount(std::shared_ptr<TurnClient> client = std::make_shared<TurnClient>())
      : client_(std::move(client)) {}

 private:
  friend class Turns;
  std::shared_ptr<TurnClient> client_;
  double used_ = 0;                    // seconds
  double turn_seconds_ = 0;            // seconds of the current or last turn
  Clock::time_point charged_until_{};  // end of the time that is charged, during a turn
  Clock::time_point quantum_begin_{};  // start of the current quantum, during a turn
};

class Turns {
 public:
  struct Options {
    unsigned concurrent = 1;    ///< frames of different scenes that may run at once, 1 or more
    bool reserves_one = false;  ///< keeps a turn free for other clients, as turns cannot be given back early
    Now now = Clock::now;
  };
  /// A frame that has run for so long yields to clients that have had less.
  static constexpr std::chrono::milliseconds kQuantum{10};

  explicit Turns(Options options) : options_(std::move(options)), free_(options_.concurrent) {}
  explicit Turns(unsigned concurrent) : Turns(Options{.concurrent = concurrent}) {}

  /// A turn, which lasts as long as this object and is charged as it goes on.
  class Turn {
   public:
    Turn(Turn&& other) noexcept : turns_(other.turns_), account_(other.account_) { other.turns_ = nullptr; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn();

    /// Seconds that it has lasted, without the waits for it.
    double seconds() const;
    /// After each quantum, if a client waits that has had less: lets it run and waits for the next turn. Nothing may
    /// run under this turn meanwhile. Throws Cancelled as take() does; the turn is over then.
    void yield_turn(const std::function<bool()>& cancelled = {});

   private:
    friend class Turns;
    Turn(Turns* turns, TurnAccount* account) : turns_(turns), account_(account) {}
    Turns* turns_;  // null once it is over
    TurnAccount* account_;
  };

  /// The account of a scene of the client with that name.
  TurnAccount account(const std::string& client);
  /// Waits for a turn. An account waits for one at a time. Throws Cancelled soon after `cancelled` turns true.
  Turn take(TurnAccount& account, const std::function<bool()>& cancelled = {});

 private:
  using Lock = std::unique_lock<std::mutex>;
  struct Waiter {
    TurnAccount* account;
    std::condition_variable woken;
  };

  // The caller holds the lock.
  void await(Lock& lock, TurnAccount& account, const std::function<bool()>& cancelled);
  void begin(TurnAccount& account);
  void end(TurnAccount& account);
  void begin_quantum(TurnAccount& account);
  void charge_running();
  bool may_run(const TurnClient& client) const;
  Waiter* next() const;
  void wake_next();
  bool should_yield(const TurnAccount& account) const;
  unsigned live_clients() const;

  const Options options_;
  std::mutex mutex_;  // guards what follows, and all accounts
  std::list<Waiter*> waiting_;
  std::vector<TurnAccount*> running_;
  std::map<std::string, std::weak_ptr<TurnClient>> clients_;
  unsigned free_;
  double virtual_time_ = 0;  // a client that was idle counts as having had at least this
};

}  // namespace collided::server
