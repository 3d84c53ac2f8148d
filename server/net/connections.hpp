#pragma once
// The connections that the process has accepted and somebody else closes: how many there may be, and which one goes
// when there is no room for a new one.

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>

#include "server/net/peer.hpp"

namespace collided::server {

/// Thread-safe. A connection is known by its descriptor and the inode of its socket, which no other socket has again:
/// whoever owns it may close it at any time.
class Connections {
 public:
  explicit Connections(size_t most) : most_(most) {}

  void set_limit(size_t most);
  /// False while there is no room and enough connections have been ended whose owner still has to close them.
  bool may_accept();
  /// Counts a connection that was just accepted; where there is no room, another one is ended. False if its source is
  /// refused: then it is not counted and must be closed.
  bool admit(int socket, const Peer& peer);
  /// The connection made a call as this client. Connections over Unix sockets cannot be told apart by their calls.
  void identified(std::string_view peer, std::string_view client);
  /// A call of the connection ended before it asked for anything. gRPC keeps each such call until it is taken up,
  /// however many come: hence a connection (or all of its source together) that makes 1,000 of them within 10 s is
  /// ended, and its source refused for 2 s. True if it was. Over Unix sockets, it is the one that has most resets
  /// waiting to be read.
  bool fruitless(std::string_view peer);
  /// Ends `count` connections, those that a full table would end.
  void end_some(size_t count);

  /// Open ones.
  size_t size() const;
  /// Ended to make room, so far.
  uint64_t evicted() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Entry {
    int socket = -1;
    ino_t inode = 0;
    Peer peer;
    Clock::time_point begin = Clock::now();
    std::string client;      ///< empty: made no call
    uint32_t fruitless = 0;  ///< calls
    bool is_ending = false;
  };
  struct Source {
    Clock::time_point begin = Clock::now();  // of the time in which they are counted
    uint32_t fruitless = 0;
    Clock::time_point refused_until{};
  };
  using Entries = std::map<uint64_t, Entry>;  // by age

  // `_locked`: the caller holds mutex_.
  void sweep_locked() const;
  void erase_locked(Entries::iterator entry) const;
  bool is_refused_locked(const std::string& source) const;
  Source& source_locked(const std::string& name);
  bool fruitless_over_unix_locked();
  Entries::iterator most_resetting_locked();
  void shut_out_locked(Entry& entry);
  bool is_evicting_enough_locked() const;
  bool make_room_locked();
  Entries::iterator victim_locked();
  Entries::iterator oldest_of_largest_group_locked(bool is_unix);
  void end_locked(Entry& entry) const;
  size_t open_locked() const { return entries_.size() - ending_; }

  mutable std::mutex mutex_;  // guards what follows
  size_t most_;
  std::unordered_map<std::string, Source> sources_;  // those with fruitless calls
  mutable Entries entries_;
  mutable std::unordered_map<std::string, uint64_t> by_peer_;  // but for Unix sockets
  mutable size_t ending_ = 0;
  uint64_t next_ = 0, evicted_ = 0;
};

}  // namespace collided::server
