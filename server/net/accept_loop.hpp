#pragma once
// Accepts connections, on a thread of its own, and hands them on.

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/net/connections.hpp"
#include "server/net/fd.hpp"

namespace collided::server {

class AcceptLoop {
 public:
  /// A connection (which does not block) and the place of its socket in the list.
  using Take = std::function<void(Fd connection, size_t place)>;

  /// Sockets and table outlive it. Where the process has no descriptor left, connections of the table are ended, and it
  /// goes on as soon as there is one. Throws std::system_error.
  AcceptLoop(std::vector<int> sockets, Connections& connections, Take take);
  ~AcceptLoop() { stop(); }
  AcceptLoop(const AcceptLoop&) = delete;
  AcceptLoop& operator=(const AcceptLoop&) = delete;

  /// No connection is handed on once it returns.
  void stop();
  /// Why nobody can connect right now; empty: everybody can.
  std::string trouble() const;

 private:
  void run();
  void take_some(size_t place);
  void begin_trouble(int error);
  void end_trouble();
  void fill_reserve();

  const std::vector<int> sockets_;
  Connections& connections_;
  const Take take_;
  Fd wake_;
  std::vector<Fd> reserve_;  // of the thread: given up for connections when there is no other descriptor
  std::atomic<bool> is_stopping_ = false;
  mutable std::mutex mutex_;
  std::string trouble_;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
