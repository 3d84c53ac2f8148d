#pragma once
// The table of accepted connections, which others close: how many there may be, what each may do before its first call,
// and which one is evicted to make room for a new one. It ends connections and refuses none.

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/net/sockets/peer.hpp"

namespace collided::server {

struct ConnectionLimits {
  size_t max = 0;          ///< connections
  size_t max_of_peer = 0;  ///< of one address, or of one user over Unix sockets
};

/// A connection that was ended.
struct EndedConnection {
  std::string peer;
  std::string_view why;
};

/// Thread-safe. A connection is identified by its descriptor and its socket's inode, which is never reused, as its
/// owner may close it at any time.
class Connections {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Connections(const ConnectionLimits& limits) : limits_(limits) {}

  void set_limits(const ConnectionLimits& limits);
  /// False while the table is full and enough evicted connections have yet to be closed by their owner.
  bool may_accept();
  /// Adds a connection that was just accepted. If there are too many, in all or of its peer, it evicts another one.
  void admit(int socket, const Peer& peer);
  /// gRPC has the connection from now on. Until then it has sent nothing.
  void handed_over(int socket);
  /// The connection made a call, whose caller may still be found (`identified`). True if the connection was ended,
  /// because it made 256 of these within 10 s without a known caller. gRPC does not tell Unix sockets apart by their
  /// calls, so calls over these are ignored here and below.
  bool called(std::string_view peer);
  /// The connection made a call as this client.
  void identified(std::string_view peer, std::string_view client);
  /// A call of the connection was abandoned before it sent a message. True if the connection was ended, because it had
  /// 1,000 of these within 10 s.
  bool abandoned(std::string_view peer);
  /// Ends connections over TCP without a call that are too old or have sent too much. To be called about once a second.
  std::vector<EndedConnection> end_callless(Clock::time_point now = Clock::now());
  /// Evicts `count` connections, as a full table would.
  void evict(size_t count);

  /// Open connections.
  size_t size() const;
  /// Connections ended so far, by eviction or for one of the limits.
  uint64_t evicted() const;

 private:
  struct Entry {
    Entry(int connection, const Peer& other);

    int socket;
    ino_t inode;
    Peer peer;
    Clock::time_point begin = Clock::now();
    std::string client;  ///< empty: no caller was known
    bool is_handed_over = false, has_called = false, is_ending = false;
    Clock::time_point counted_since{};
    uint32_t wasted = 0;  ///< calls since then that were abandoned, or came while no caller was known
  };
  using Entries = std::map<uint64_t, Entry>;  // by age
  /// Finds strings by views, of each call's peer.
  struct NameHash : std::hash<std::string_view> {
    using is_transparent = void;
  };

  // `_locked`: the caller holds mutex_.
  void sweep_locked() const;
  void erase_locked(Entries::iterator entry) const;
  Entry* find_locked(std::string_view peer);
  bool waste_locked(Entry& entry);
  bool is_evicting_enough_locked() const;
  bool evict_one_locked(std::string_view source = {});
  Entries::iterator victim_locked(std::string_view source);
  Entries::iterator oldest_of_largest_group_locked(std::string_view source, bool is_unix);
  size_t open_of_locked(std::string_view source) const;
  void end_locked(Entry& entry) const;
  size_t open_locked() const { return entries_.size() - ending_; }

  mutable std::mutex mutex_;  // guards what follows
  ConnectionLimits limits_;
  mutable Entries entries_;
  mutable std::unordered_map<std::string, uint64_t, NameHash, std::equal_to<>> by_peer_;  // without Unix sockets
  mutable size_t ending_ = 0;
  mutable Clock::time_point swept_{};
  uint64_t next_ = 0, evicted_ = 0;
};

}  // namespace collided::server
