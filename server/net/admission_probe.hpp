#pragma once
// Checks whether new clients can connect: connects to the daemon's own sockets periodically and waits for an answer.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace collided::server {

/// A listening socket that speaks HTTP/2, or HTTP/2 over TLS.
struct ProbeTarget {
  int socket = -1;
  bool is_tls = false;
  std::string address;  ///< for messages
};

class AdmissionProbe {
 public:
  /// `shortage` returns what is known to be wrong without a probe ("": nothing). `report` is called with what keeps new
  /// clients out ("" once nothing does) whenever that changes. The probe's thread calls both. The sockets must outlive
  /// the probe. It stops waiting for an answer on a shortage, or when it is to end.
  AdmissionProbe(std::vector<ProbeTarget> targets, std::function<std::string()> shortage,
                 std::function<void(const std::string& obstacle)> report);
  ~AdmissionProbe();
  AdmissionProbe(const AdmissionProbe&) = delete;
  AdmissionProbe& operator=(const AdmissionProbe&) = delete;

 private:
  void run();
  std::string check();
  std::string probe_all() const;
  bool should_stop() const { return is_stopping_ || !shortage_().empty(); }
  bool wait(std::chrono::milliseconds time);

  const std::vector<ProbeTarget> targets_;
  const std::function<std::string()> shortage_;
  const std::function<void(const std::string&)> report_;
  std::string reported_;                          // owned by the thread
  std::chrono::steady_clock::time_point next_{};  // time of the next probe; owned by the thread
  std::mutex mutex_;
  std::condition_variable stopping_;
  std::atomic<bool> is_stopping_ = false;  // changed under mutex_
  std::thread thread_;
};

/// Connects and waits for the server's first bytes: its HTTP/2 SETTINGS, or its part of a TLS handshake. Returns what
/// is wrong, or "". Calls `should_stop` four times a second to see whether to give up.
std::string probe(
    const ProbeTarget& target, const std::function<bool()>& should_stop = [] { return false; });

}  // namespace collided::server
