#pragma once
// Looks for connections that flood, on a thread of its own: gRPC may read such a connection on the thread that accepts.

#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/net/connections.hpp"

namespace collided::server {

class FloodWatch {
 public:
  /// The table must outlive it.
  explicit FloodWatch(Connections& connections);
  ~FloodWatch();
  FloodWatch(const FloodWatch&) = delete;
  FloodWatch& operator=(const FloodWatch&) = delete;

 private:
  void run();

  Connections& connections_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool is_stopping_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
