#pragma once
// Whether a new client gets in: connects to the daemon's own sockets now and then, and waits for an answer.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace collided::server {

/// A listening socket that speaks HTTP/2, or TLS before it.
struct Door {
  int socket = -1;
  bool is_tls = false;
  std::string address;  ///< for messages
};

class AdmissionProbe {
 public:
  /// `trouble` (may be empty) is what is known to be wrong without trying. `tell` is called with what keeps new clients
  /// out ("" once they get in), each time that it changes. Both by the probe's thread. The sockets outlive the probe.
  /// It waits for no answer any more once there is trouble, or once it is to end.
  AdmissionProbe(std::vector<Door> doors, std::function<std::string()> trouble,
                 std::function<void(const std::string& obstacle)> tell);
  ~AdmissionProbe();
  AdmissionProbe(const AdmissionProbe&) = delete;
  AdmissionProbe& operator=(const AdmissionProbe&) = delete;

 private:
  void run();
  std::string look();
  std::string knock_everywhere() const;
  bool is_pointless() const { return is_stopping_ || !trouble_().empty(); }
  bool wait(std::chrono::milliseconds time);

  const std::vector<Door> doors_;
  const std::function<std::string()> trouble_;
  const std::function<void(const std::string&)> tell_;
  std::string told_;                              // of the thread
  std::chrono::steady_clock::time_point next_{};  // when it knocks again; of the thread
  std::mutex mutex_;
  std::condition_variable stopping_;
  std::atomic<bool> is_stopping_ = false;  // changed under mutex_
  std::thread thread_;
};

/// Connects and waits for the server's first bytes: its HTTP/2 SETTINGS, or its part of a TLS handshake. What is wrong;
/// empty if nothing is. Asks `is_pointless` four times a second whether to give up.
std::string knock(
    const Door& door, const std::function<bool()>& is_pointless = [] { return false; });

}  // namespace collided::server
