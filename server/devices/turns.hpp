#pragma once
// Decides who works next when many share a device, by start-time fair queuing on a tree. The waiting group that has
// used the least time goes first; within it, the group or scene that has used the least. No gRPC here.

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/auth/turn_path.hpp"
#include "server/devices/load.hpp"
#include "server/ops/clock.hpp"

namespace collided::server {

class TurnAccount;

/// A node of the tree: all clients of one address, a client, or one scene. Guarded by the mutex of its Turns.
class TurnShare {
 public:
  TurnShare() = default;

 private:
  friend class Turns;
  friend class TurnAccount;
  explicit TurnShare(std::shared_ptr<TurnShare> parent) : parent_(std::move(parent)) {}

  std::shared_ptr<TurnShare> parent_;  // null: the root
  std::map<std::string, std::weak_ptr<TurnShare>> groups_;
  std::vector<TurnShare*> waiting_;  // of its children
  TurnAccount* account_ = nullptr;   // that waits here; null for a group
  uint64_t arrival_ = 0;             // of its earliest waiter
  double used_ = 0;                  // seconds
  double virtual_time_ = 0;          // lower bound of a child's time when it becomes busy again
  unsigned running_ = 0;             // turns
};

/// The time that a scene has used, or a call. Neither scenes nor clients accrue credit while idle.
class TurnAccount : public TurnShare {
 public:
  /// Makes an account of a client that has no other.
  TurnAccount() : TurnShare(std::make_shared<TurnShare>()) {}

 private:
  friend class Turns;
  explicit TurnAccount(std::shared_ptr<TurnShare> client) : TurnShare(std::move(client)) {}

  std::function<void()> granted_;      // while it waits
  double turn_seconds_ = 0;            // seconds of the current or last turn
  Clock::time_point charged_until_{};  // the turn's time is charged up to here
  Clock::time_point quantum_begin_{};  // start of the turn's current quantum
};

class Turns {
 public:
  struct Options {
    unsigned concurrent = 1;    ///< turns of different accounts that may run at once, 1 or more
    bool reserves_one = false;  ///< keeps a turn free for other clients, for turns that cannot yield
    Now now = Clock::now;
  };
  /// A turn that has run for this long yields to clients that have used less time.
  static constexpr std::chrono::milliseconds kQuantum{10};

  explicit Turns(Options options);
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

  /// A new account of the client with that path.
  TurnAccount account(const TurnPath& client);
  /// Waits for a turn; an account for one at a time. Throws Cancelled soon after `cancelled` turns true.
  Turn take(TurnAccount& account, const std::function<bool()>& cancelled = {});
  /// Calls `granted` with the turn once it has come, on any thread and perhaps at once. `granted` must not throw, wait
  /// or end the turn, but pass it on. The account outlives the turn. If this throws, `granted` is not called.
  void request(TurnAccount& account, std::function<void(Turn)> granted);

  unsigned concurrent() const { return options_.concurrent; }
  /// Seconds that turns run a second, of late.
  double load();
  /// Seconds that turns have run, all together.
  double busy_seconds();
  /// Accounts that wait for a turn.
  size_t waiting();

 private:
  using Lock = std::unique_lock<std::mutex>;

  // The caller holds the lock.
  void prepare(TurnAccount& account);
  void await(Lock& lock, TurnAccount& account, const std::function<bool()>& cancelled);
  void join(TurnAccount& account, std::function<void()> granted);
  void leave(TurnAccount& account);
  void grant();
  void begin(TurnAccount& account);
  void end(TurnAccount& account);
  void begin_quantum(TurnAccount& account);
  void charge_running();
  TurnShare& above(const TurnShare& share) { return share.parent_ ? *share.parent_ : root_; }
  template <class Use>
  void for_each_up(TurnShare& from, const Use& use);
  std::shared_ptr<TurnShare> group(const std::shared_ptr<TurnShare>& parent, const std::string& name);
  void keep_debt(const TurnAccount& account);
  void forget_debts();
  bool may_run(const TurnShare& share, const TurnShare& above) const;
  bool has_next(const TurnShare& share, const TurnShare& above) const;
  TurnAccount* next_of(const TurnShare& share) const;
  bool should_yield(const TurnAccount& account);

  const Options options_;
  std::mutex mutex_;  // guards what follows, and all shares
  TurnShare root_;
  size_t waiting_ = 0;  // accounts
  uint64_t arrivals_ = 0;
  std::vector<TurnAccount*> running_;
  std::vector<std::shared_ptr<TurnShare>> debtors_;  // clients that have used more than their share, even absent ones
  unsigned free_;
  Load load_;
};

}  // namespace collided::server
