#pragma once
// Accepts connections on its own thread and hands them on.

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/net/connections.hpp"
#include "server/net/sockets/fd.hpp"
#include "server/net/waiting_connections.hpp"

namespace collided::server {

class AcceptLoop {
 public:
  /// A non-blocking connection, and the index of its socket in the list.
  using Take = std::function<void(Fd connection, size_t place)>;

  /// Returns false while whoever takes the connections has enough to do.
  using MayTake = std::function<bool()>;

  /// Sockets and table must outlive it. When the process runs out of descriptors it evicts connections from the table,
  /// and accepts again as soon as a descriptor is free. With `may_take`, connections are for gRPC: they wait for their
  /// turn (WaitingConnections) and are ended if they make no call. Throws std::system_error.
  AcceptLoop(std::vector<int> sockets, Connections& connections, Take take, MayTake may_take = {});
  ~AcceptLoop() { stop(); }
  AcceptLoop(const AcceptLoop&) = delete;
  AcceptLoop& operator=(const AcceptLoop&) = delete;

  /// Hands on no connection after it returns.
  void stop();
  /// Why no client can connect at the moment; empty if clients can.
  std::string shortage() const;

 private:
  void run();
  void look();
  int patience_ms(bool is_short, bool is_full) const;
  void accept_batch(size_t place);
  void hand_over();
  void end_callless();
  void on_shortage(int error);
  void on_recovery();
  void fill_reserve();

  const std::vector<int> sockets_;
  Connections& connections_;
  const Take take_;
  const MayTake may_take_;
  // Owned by the thread:
  WaitingConnections waiting_;
  std::chrono::steady_clock::time_point next_check_{};
  Fd wake_;
  std::vector<Fd> reserve_;  // closed to make room when no other descriptor is left
  std::atomic<bool> is_stopping_ = false;
  mutable std::mutex mutex_;
  std::string shortage_;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
