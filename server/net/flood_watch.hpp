#pragma once
// Looks for connections that flood, on a thread of its own: gRPC may read such a connection on the thread that accepts.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "server/net/connections.hpp"

namespace collided::server {

class FloodWatch {
 public:
  /// The table must outlive it. `report` is called for each connection that is ended, on the watch's thread.
  FloodWatch(Connections& connections, std::function<void(const EndedFlood& flood)> report);
  ~FloodWatch();
  FloodWatch(const FloodWatch&) = delete;
  FloodWatch& operator=(const FloodWatch&) = delete;

 private:
  void run();
  void look();

  Connections& connections_;
  const std::function<void(const EndedFlood&)> report_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool is_stopping_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
