#pragma once
// Calls that wait for their client: a limited number of them, each for a limited time. No gRPC here.

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "server/auth/client.hpp"

namespace collided::server {

struct WaitRule {
  std::string what;          ///< what is awaited, such as "the opening of a stream"
  double seconds = 10;       ///< then DeadlineExceeded
  size_t max = 0;            ///< calls that may wait for this at once
  size_t max_of_client = 0;  ///< of them, of one client
  std::string source = {};   ///< tells clients of the same name apart; may be empty
};

/// Thread-safe.
class WaitingCalls {
 public:
  /// Called at most once, with the reason, and without a lock held.
  using End = std::function<void(const std::exception_ptr& why)>;

  /// One wait, ended by its destruction. May outlive the WaitingCalls.
  class Wait {
   public:
    ~Wait() { finish(); }
    Wait(const Wait&) = delete;
    Wait& operator=(const Wait&) = delete;
    /// The client has answered. False if `end` has been or is being called: whichever comes first wins.
    bool finish();

   private:
    friend class WaitingCalls;
    struct State;
    explicit Wait(std::shared_ptr<State> state) : state_(std::move(state)) {}
    const std::shared_ptr<State> state_;
  };

  WaitingCalls();
  ~WaitingCalls();

  /// If more calls wait than the rule allows, the new one evicts the one that has waited longest (LimitExceeded), as
  /// honest clients answer at once. At the limit for all clients, it evicts a call of the client with the most.
  std::unique_ptr<Wait> wait(const WaitRule& rule, const Client& client, End end);
  size_t waiting() const;

 private:
  struct Shared;
  void run();

  const std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace collided::server
