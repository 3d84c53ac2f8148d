#pragma once
// Whose frame runs next when many scenes share a device: start-time fair queuing on two levels. The waiting client that
// has used the least time goes first, and among its scenes the one that has used the least. No gRPC here.

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "server/limits/load.hpp"
#include "server/ops/clock.hpp"

namespace collided::server {

class TurnAccount;

/// A frame that waits for its turn.
struct TurnWaiter {
  TurnAccount* account;
  double used;       // by the scene, in seconds
  uint64_t arrival;  // its number among all
  std::condition_variable woken;
};
/// Of one client's.
struct GoesFirst {
  bool operator()(const TurnWaiter* a, const TurnWaiter* b) const {
    return std::pair(a->used, a->arrival) < std::pair(b->used, b->arrival);
  }
};

/// The time that one client's scenes have used together.
class TurnClient {
  friend class Turns;
  std::set<TurnWaiter*, GoesFirst> waiting_;
  double used_ = 0;          // seconds
  double virtual_time_ = 0;  // lower bound of a scene's time when it becomes busy again
  unsigned running_ = 0;     // turns
};

/// The time that a scene has used. Neither scenes nor clients accrue credit while idle.
class TurnAccount {
 public:
  explicit TurnAccount(std::shared_ptr<TurnClient> client = std::make_shared<TurnClient>())
      : client_(std::move(client)) {}

 private:
  friend class Turns;
  std::shared_ptr<TurnClient> client_;
  double used_ = 0;                    // seconds
  double turn_seconds_ = 0;            // seconds of the current or last turn
  Clock::time_point charged_until_{};  // the turn's time is charged up to here
  Clock::time_point quantum_begin_{};  // start of the turn's current quantum
};

class Turns {
 public:
  struct Options {
    unsigned concurrent = 1;    ///< frames of different scenes that may run at once, 1 or more
    bool reserves_one = false;  ///< keeps a turn free for other clients, for turns that cannot yield
    Now now = Clock::now;
  };
  /// A frame that has run for this long yields to clients that have used less time.
  static constexpr std::chrono::milliseconds kQuantum{10};

  explicit Turns(Options options) : options_(std::move(options)), free_(options_.concurrent), load_(options_.now()) {}
  explicit Turns(unsigned concurrent) : Turns(Options{.concurrent = concurrent}) {}

  /// A turn, held while this object lives and charged as it runs.
  class Turn {
   public:
    Turn(Turn&& other) noexcept : turns_(other.turns_), account_(other.account_) { other.turns_ = nullptr; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn();

    /// Seconds that it has run, not counting waits.
    double seconds() const;
    /// Once per quantum, if a client that has used less time is waiting: gives the turn up and waits for the next one.
    /// Nothing may run under this turn meanwhile. Throws Cancelled as take() does; the turn is over then.
    void yield_turn(const std::function<bool()>& cancelled = {});

   private:
    friend class Turns;
    Turn(Turns* turns, TurnAccount* account) : turns_(turns), account_(account) {}
    Turns* turns_;  // null once it is over
    TurnAccount* account_;
  };

  /// The account of a scene of the client with that name.
  TurnAccount account(const std::string& client);
  /// Waits for a turn; an account for one at a time. Throws Cancelled soon after `cancelled` turns true.
  Turn take(TurnAccount& account, const std::function<bool()>& cancelled = {});

  /// Seconds that turns run a second, of late.
  double load();
  /// Seconds that turns have run, all together.
  double busy_seconds();
  /// Frames that wait for a turn.
  size_t waiting();

 private:
  using Lock = std::unique_lock<std::mutex>;

  // The caller holds the lock.
  void await(Lock& lock, TurnAccount& account, const std::function<bool()>& cancelled);
  void join(TurnWaiter& waiter);
  void leave(TurnWaiter& waiter);
  void begin(TurnAccount& account);
  void end(TurnAccount& account);
  void begin_quantum(TurnAccount& account);
  void charge_running();
  bool may_run(const TurnClient& client) const;
  TurnWaiter* next() const;
  void wake_next();
  bool should_yield(const TurnAccount& account) const;
  unsigned live_clients() const;

  const Options options_;
  std::mutex mutex_;                          // guards what follows, and all accounts
  std::vector<TurnClient*> waiting_clients_;  // each has a waiter
  size_t waiting_ = 0;                        // of all clients
  uint64_t arrivals_ = 0;
  std::vector<TurnAccount*> running_;
  std::map<std::string, std::weak_ptr<TurnClient>> clients_;
  unsigned free_;
  double virtual_time_ = 0;  // lower bound of a client's time when it becomes busy again
  Load load_;
};

}  // namespace collided::server
