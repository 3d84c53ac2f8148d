#pragma once
// The turn of a frame whose scene is on several devices: one on each. No gRPC here.

#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "server/devices/turns.hpp"

namespace collided::server {

class TurnsOfScene {
 public:
  /// Turns on all devices, held while this lives.
  class Turn {
   public:
    /// Seconds that it has run, not counting waits: since it had the last device.
    double seconds() const { return turns_.back().seconds(); }
    /// As Turns::Turn::yield_turn. Whoever holds turns on several devices keeps them: two that each wait for what the
    /// other has would wait forever.
    void yield_turn(const std::function<bool()>& cancelled) {
      if (turns_.size() == 1) turns_.front().yield_turn(cancelled);
    }

   private:
    friend class TurnsOfScene;
    std::vector<Turns::Turn> turns_;
  };

  /// `devices`: of the scene, each once, in the same order for all scenes, so that no two wait for each other.
  TurnsOfScene(const std::vector<Turns*>& devices, const TurnPath& client) : client_(client) {
    for (Turns* turns : devices) accounts_.push_back({turns, turns->account(client)});
  }

  /// Later turns are that client's. From any thread.
  void charge_to(TurnPath client) {
    const std::lock_guard lock(mutex_);
    next_client_ = std::move(client);
  }

  /// Waits for a turn on each; for one frame at a time. Throws as Turns::take does.
  Turn take(const std::function<bool()>& cancelled) {
    change_client();
    Turn turn;
    for (auto& [turns, account] : accounts_) turn.turns_.push_back(turns->take(account, cancelled));
    return turn;
  }

 private:
  struct Account {
    Turns* turns;
    TurnAccount account;
  };

  // Not while there is a turn.
  void change_client() {
    std::optional<TurnPath> next;
    {
      const std::lock_guard lock(mutex_);
      next.swap(next_client_);
    }
    if (!next || *next == client_) return;
    std::deque<Account> accounts;
    for (const Account& old : accounts_) accounts.push_back({old.turns, old.turns->account(*next)});
    accounts_.swap(accounts);
    client_ = *std::move(next);
  }

  std::mutex mutex_;
  std::optional<TurnPath> next_client_;  // guarded by mutex_
  TurnPath client_;
  std::deque<Account> accounts_;  // which never move
};

}  // namespace collided::server
