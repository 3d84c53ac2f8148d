#pragma once
// Accepts connections on its own thread and hands them on.

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/net/connections.hpp"
#include "server/net/sockets/fd.hpp"

namespace collided::server {

class AcceptLoop {
 public:
  /// A non-blocking connection, and the index of its socket in the list.
  using Take = std::function<void(Fd connection, size_t place)>;

  /// Sockets and table must outlive it. When the process runs out of descriptors it evicts connections from the table,
  /// and accepts again as soon as a descriptor is free. Throws std::system_error.
  AcceptLoop(std::vector<int> sockets, Connections& connections, Take take);
  ~AcceptLoop() { stop(); }
  AcceptLoop(const AcceptLoop&) = delete;
  AcceptLoop& operator=(const AcceptLoop&) = delete;

  /// Hands on no connection after it returns.
  void stop();
  /// Why no client can connect at the moment; empty if clients can.
  std::string shortage() const;

 private:
  void run();
  void accept_batch(size_t place);
  void on_shortage(int error);
  void on_recovery();
  void fill_reserve();

  const std::vector<int> sockets_;
  Connections& connections_;
  const Take take_;
  Fd wake_;
  std::vector<Fd> reserve_;  // owned by the thread; closed to make room when no other descriptor is left
  std::atomic<bool> is_stopping_ = false;
  mutable std::mutex mutex_;
  std::string shortage_;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
