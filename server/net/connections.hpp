#pragma once
// The table of accepted connections, which others close: how many there may be, and which one is evicted to make room
// for a new one.

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/net/flood_meter.hpp"
#include "server/net/sockets/peer.hpp"

namespace collided::server {

/// A connection that was ended.
struct EndedFlood {
  std::string peer, client;
  std::string_view what;  ///< what it flooded with
};

/// Thread-safe. A connection is identified by its descriptor and its socket's inode, which is never reused, as its
/// owner may close it at any time.
class Connections {
 public:
  /// `max_unfinished`: bytes that may have come from one client of messages that are not complete.
  explicit Connections(size_t max, uint64_t max_unfinished = UINT64_MAX) : max_unfinished_(max_unfinished), max_(max) {}

  void set_limit(size_t max);
  /// False while the table is full and enough evicted connections have yet to be closed by their owner.
  bool may_accept();
  /// Adds a connection that was just accepted; evicts another one if the table is full. False if its source is refused:
  /// then it is not added and must be closed.
  bool admit(int socket, const Peer& peer);
  /// The connection made a call as this client. Unix sockets cannot be told apart by their calls.
  void identified(std::string_view peer, std::string_view client);
  /// A call of the connection was abandoned before it sent a message. gRPC keeps each such call until it is accepted,
  /// however many there are, so a connection whose source makes 1,000 of them within 10 s is ended, and the source
  /// refused for 2 s. True if it was. Over Unix sockets it is the connection with the most unread resets.
  bool abandoned(std::string_view peer);
  /// A call from there has begun, or ended.
  void began(std::string_view peer);
  void ended(std::string_view peer);
  /// A message of so many bytes has come from there, or is about to be sent there.
  void received(std::string_view peer, uint64_t bytes);
  void sent(std::string_view peer, uint64_t bytes);
  /// Ends connections over TCP that flood, and refuses their sources for 2 s. To be called a few times a second.
  std::vector<EndedFlood> end_floods();
  /// Evicts `count` connections, as a full table would.
  void evict(size_t count);

  /// Open connections.
  size_t size() const;
  /// Connections evicted so far.
  uint64_t evicted() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Entry {
    Entry(int connection, const Peer& other);

    int socket;
    ino_t inode;
    Peer peer;
    Clock::time_point begin = Clock::now();
    std::string client;      ///< empty: made no call
    uint32_t abandoned = 0;  ///< calls
    std::unique_ptr<FloodMeter> meter;  ///< over TCP
    bool is_ending = false;
  };
  struct Source {
    Clock::time_point begin = Clock::now();  // of the period in which calls are counted
    uint32_t abandoned = 0;
    Clock::time_point refused_until{};
  };
  using Entries = std::map<uint64_t, Entry>;  // by age
  /// Finds strings by views, of each message's peer.
  struct NameHash : std::hash<std::string_view> {
    using is_transparent = void;
  };
  struct Watched {
    uint64_t id = 0;
    int socket = -1;
    ino_t inode = 0;
    std::optional<Traffic> traffic = {};
    bool is_open = false;
  };

  std::vector<Watched> prepare_looks();
  // `_locked`: the caller holds mutex_.
  void sweep_locked() const;
  void erase_locked(Entries::iterator entry) const;
  bool is_refused_locked(const std::string& source) const;
  Source& source_locked(const std::string& name);
  bool abandoned_over_unix_locked();
  Entries::iterator most_resetting_locked();
  void shut_out_locked(Entry& entry);
  Entry* find_locked(std::string_view peer);
  EndedFlood end_flood_locked(Entry& entry, std::string_view what);
  void end_unfinished_locked(std::vector<EndedFlood>& ended);
  bool is_evicting_enough_locked() const;
  bool make_room_locked();
  Entries::iterator victim_locked();
  Entries::iterator oldest_of_largest_group_locked(bool is_unix);
  void end_locked(Entry& entry) const;
  size_t open_locked() const { return entries_.size() - ending_; }

  const uint64_t max_unfinished_;
  mutable std::mutex mutex_;  // guards what follows
  size_t max_;
  std::unordered_map<std::string, Source> sources_;  // with abandoned calls
  mutable Entries entries_;
  mutable std::unordered_map<std::string, uint64_t, NameHash, std::equal_to<>> by_peer_;  // without Unix sockets
  mutable size_t ending_ = 0;
  uint64_t next_ = 0, evicted_ = 0;
};

}  // namespace collided::server
