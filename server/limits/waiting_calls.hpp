#pragma once
// Calls that wait for their client: each for a limited time, and a limited number of them. No gRPC here.

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
  double seconds = 10;       ///< DeadlineExceeded after that
  size_t max = 0;            ///< number of calls that may wait for this at once
  size_t max_of_client = 0;  ///< of them, of one client
  std::string source = {};   ///< distinguishes clients of one name; may be empty
};

/// Thread-safe.
class WaitingCalls {
 public:
  /// Called at most once, with why the wait was ended; no lock is held.
  using End = std::function<void(const std::exception_ptr& why)>;

  /// One wait, until it is destroyed. May outlive the calls.
  class Wait {
   public:
    ~Wait() { finish(); }
    Wait(const Wait&) = delete;
    Wait& operator=(const Wait&) = delete;
    /// The client has answered. False if `end` is being called, or was: whichever comes first decides.
    bool finish();

   private:
    friend class WaitingCalls;
    struct State;
    explicit Wait(std::shared_ptr<State> state) : state_(std::move(state)) {}
    const std::shared_ptr<State> state_;
  };

  WaitingCalls();
  ~WaitingCalls();

  /// If more calls wait than the rule allows, the one that has waited longest is ended (LimitExceeded) for the new one,
  /// as honest clients answer at once. If the limit for all is reached, it is one of the client with the most.
  std::unique_ptr<Wait> wait(const WaitRule& rule, const Client& client, End end);
  size_t waiting() const;

 private:
  struct Shared;
  void run();

  const std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace collided::server
