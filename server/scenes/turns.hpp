#pragma once
// Whose frame runs next where many scenes share a device: start-time fair queuing on two levels. Of the clients that
// wait, the one that has had the least time; of its scenes, the one that has. No gRPC here.

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

/// What the scenes of one client have had together.
class TurnClient {
  friend class Turns;
  double used_ = 0;       // seconds
  double now_ = 0;        // the least that a scene of this client which was idle counts as having had
  unsigned running_ = 0;  // turns
};

/// A scene's share. Neither it nor its client saves up turns while idle.
class TurnAccount {
 public:
  explicit TurnAccount(std::shared_ptr<TurnClient> client = std::make_shared<TurnClient>())
      : client_(std::move(client)) {}

 private:
  friend class Turns;
  std::shared_ptr<TurnClient> client_;
  double used_ = 0;              // seconds
  double of_turn_ = 0;           // of the present or last turn alone
  Clock::time_point charged_{};  // until when, while it has a turn
  Clock::time_point resumed_{};  // since when its quantum runs, while it has a turn
};

class Turns {
 public:
  struct Options {
    unsigned at_once = 1;         ///< frames of different scenes that run beside each other, 1 or more
    bool keeps_one_free = false;  ///< for other clients, if there are any: turns cannot be given back early
    Now now = Clock::now;
  };
  /// A frame that has run for so long gives way to clients that have had less.
  static constexpr std::chrono::milliseconds kQuantum{10};

  explicit Turns(Options options) : options_(std::move(options)), free_(options_.at_once) {}
  explicit Turns(unsigned at_once) : Turns(Options{.at_once = at_once}) {}

  /// Lasts as long as this object, and is charged as it goes.
  class Turn {
   public:
    Turn(Turn&& other) noexcept : turns_(other.turns_), account_(other.account_) { other.turns_ = nullptr; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn();

    /// For how long it has run, without the waits for it.
    double seconds() const;
    /// After each quantum, if a client waits that has had less: lets it run, and waits for the next turn. Nothing may
    /// run under this turn meanwhile. Throws Cancelled as take() does; the turn is over then.
    void give_way(const std::function<bool()>& cancelled = {});

   private:
    friend class Turns;
    Turn(Turns* turns, TurnAccount* account) : turns_(turns), account_(account) {}
    Turns* turns_;  // null: over
    TurnAccount* account_;
  };

  /// For a scene of the client with that name.
  TurnAccount account(const std::string& client);
  /// Waits for a turn. An account waits for one at a time. Throws Cancelled soon after `cancelled` turns true.
  Turn take(TurnAccount& account, const std::function<bool()>& cancelled = {});

 private:
  using Lock = std::unique_lock<std::mutex>;
  struct Waiter {
    TurnAccount* account;
    std::condition_variable called;
  };

  // All with the lock.
  void await(Lock& lock, TurnAccount& account, const std::function<bool()>& cancelled);
  void begin(TurnAccount& account);
  void end(TurnAccount& account);
  void begin_quantum(TurnAccount& account);
  void charge_running();
  bool may_run(const TurnClient& client) const;
  Waiter* next() const;
  void call_next();
  bool should_give_way(const TurnAccount& account) const;
  unsigned live_clients() const;

  const Options options_;
  std::mutex mutex_;  // guards what follows, and all accounts
  std::list<Waiter*> waiting_;
  std::vector<TurnAccount*> running_;
  std::map<std::string, std::weak_ptr<TurnClient>> clients_;
  unsigned free_;
  double now_ = 0;  // the least that a client which was idle counts as having had
};

}  // namespace collided::server
