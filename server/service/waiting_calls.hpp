#pragma once
// Calls that wait for their client: each only for so long, and only so many of them. No gRPC here.

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
  std::string what;           ///< is awaited, such as "the opening of a stream"
  double seconds = 10;        ///< DeadlineExceeded after it
  size_t most = 0;            ///< that wait for this at once
  size_t most_of_client = 0;  ///< of them, of one client
  std::string source = {};    ///< tells clients of one name apart; may be empty
};

/// Thread-safe.
class WaitingCalls {
 public:
  /// Told at most once that the wait is over, and why; no lock is held.
  using End = std::function<void(const std::exception_ptr& why)>;

  /// One wait, until it is destroyed. May outlive the calls.
  class Wait {
   public:
    ~Wait() { over(); }
    Wait(const Wait&) = delete;
    Wait& operator=(const Wait&) = delete;
    /// The client has answered. False if its `end` is told, or was: whoever takes the wait out first decides.
    bool over();

   private:
    friend class WaitingCalls;
    struct State;
    explicit Wait(std::shared_ptr<State> state) : state_(std::move(state)) {}
    const std::shared_ptr<State> state_;
  };

  WaitingCalls();
  ~WaitingCalls();

  /// Where more wait than the rule allows, the one that has waited longest is ended (LimitExceeded) for the new one:
  /// honest clients answer at once. Where all are too many, it is one of the client that has most.
  std::unique_ptr<Wait> wait(const WaitRule& rule, const Client& client, End end);
  size_t waiting() const;

 private:
  struct Shared;
  void run();

  const std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace collided::server
