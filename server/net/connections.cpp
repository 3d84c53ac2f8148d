// The table of accepted connections, which others close.
#include "server/net/connections.hpp"

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>

#include "server/net/sockets/fd.hpp"

namespace collided::server {
namespace {

// An honest client makes its first call at once. It may also connect first and read its meshes then.
constexpr auto kTimeForFirstCall = std::chrono::seconds(10);  // after it, the connection is the first to be evicted
constexpr auto kMaxTimeWithoutCall = std::chrono::seconds(60);
// gRPC lets a client send 4 MiB on each stream before a call of it is accepted, which takes a while on a busy machine.
constexpr uint64_t kMaxBytesWithoutCall = 64 << 20;
constexpr auto kCountedTime = std::chrono::seconds(10);
constexpr uint32_t kMaxWasted = 1000;           // calls; an honest client may cancel many at once
constexpr uint32_t kMaxWastedOfStranger = 256;  // of a connection without a known caller; some ask for health
// Between two sweeps, of which a flood of connections would take thousands a second.
constexpr auto kMinSweepInterval = std::chrono::milliseconds(5);

}  // namespace

Connections::Entry::Entry(int connection, const Peer& other)
    : socket(connection), inode(inode_of(connection)), peer(other) {}

void Connections::set_limits(const ConnectionLimits& limits) {
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

bool Connections::may_accept() {
  const std::lock_guard lock(mutex_);
  if (open_locked() < limits_.max || !is_evicting_enough_locked()) return true;
  sweep_locked();
  return open_locked() < limits_.max || !is_evicting_enough_locked();
}

void Connections::admit(int socket, const Peer& peer) {
  const std::lock_guard lock(mutex_);
  if (Clock::now() - swept_ > kMinSweepInterval) sweep_locked();
  while (open_of_locked(peer.source) >= limits_.max_of_peer && evict_one_locked(peer.source)) continue;
  while (open_locked() >= limits_.max && evict_one_locked()) continue;
  const uint64_t id = next_++;
  entries_.try_emplace(id, socket, peer);
  if (!peer.is_unix) by_peer_[peer.name] = id;
}

void Connections::handed_over(int socket) {
  const ino_t inode = inode_of(socket);
  const std::lock_guard lock(mutex_);
  const auto is_it = [&](const auto& one) { return one.second.socket == socket && one.second.inode == inode; };
  const auto found = std::find_if(entries_.rbegin(), entries_.rend(), is_it);
  if (found != entries_.rend()) found->second.is_handed_over = true;
}

bool Connections::called(std::string_view peer) {
  const std::lock_guard lock(mutex_);
  Entry* const entry = find_locked(peer);
  if (!entry) return false;
  entry->has_called = true;
  return entry->client.empty() && waste_locked(*entry);
}

void Connections::identified(std::string_view peer, std::string_view client) {
  const std::lock_guard lock(mutex_);
  Entry* const entry = find_locked(peer);
  if (entry && entry->client != client) entry->client = client;
}

bool Connections::abandoned(std::string_view peer) {
  const std::lock_guard lock(mutex_);
  Entry* const entry = find_locked(peer);
  return entry && waste_locked(*entry);
}

bool Connections::waste_locked(Entry& entry) {
  const auto now = Clock::now();
  if (now - entry.counted_since > kCountedTime) {
    entry.counted_since = now;
    entry.wasted = 0;
  }
  if (entry.is_ending || ++entry.wasted < (entry.client.empty() ? kMaxWastedOfStranger : kMaxWasted)) return false;
  end_locked(entry);
  ++evicted_;
  return true;
}

Connections::Entry* Connections::find_locked(std::string_view peer) {
  const auto found = by_peer_.find(peer);
  return found == by_peer_.end() ? nullptr : &entries_.at(found->second);
}

std::vector<EndedConnection> Connections::end_callless(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  sweep_locked();
  std::vector<EndedConnection> ended;
  for (auto& [id, entry] : entries_) {
    if (entry.peer.is_unix || entry.has_called || entry.is_ending) continue;
    const bool is_late = now - entry.begin > kMaxTimeWithoutCall;
    if (!is_late && received_bytes(entry.socket) <= kMaxBytesWithoutCall) continue;
    end_locked(entry);
    ++evicted_;
    ended.push_back({entry.peer.name, is_late ? "no call within a minute" : "64 MiB without a call"});
  }
  return ended;
}

void Connections::evict(size_t count) {
  const std::lock_guard lock(mutex_);
  sweep_locked();
  while (count-- > 0 && evict_one_locked()) continue;
}

size_t Connections::size() const {
  const std::lock_guard lock(mutex_);
  sweep_locked();
  return open_locked();
}

uint64_t Connections::evicted() const {
  const std::lock_guard lock(mutex_);
  return evicted_;
}

void Connections::sweep_locked() const {
  swept_ = Clock::now();
  for (auto next = entries_.begin(); next != entries_.end();) {
    const auto entry = next++;
    if (inode_of(entry->second.socket) != entry->second.inode) erase_locked(entry);
  }
}

void Connections::erase_locked(Entries::iterator entry) const {
  const auto named = by_peer_.find(entry->second.peer.name);
  if (named != by_peer_.end() && named->second == entry->first) by_peer_.erase(named);
  ending_ -= entry->second.is_ending;
  entries_.erase(entry);
}

size_t Connections::open_of_locked(std::string_view source) const {
  if (limits_.max_of_peer >= limits_.max) return 0;  // the limit of all comes first
  return static_cast<size_t>(std::ranges::count_if(
      entries_, [&](const auto& one) { return one.second.peer.source == source && !one.second.is_ending; }));
}

// An evicted connection keeps its descriptor until its owner notices, so their number is limited.
bool Connections::is_evicting_enough_locked() const {
  constexpr size_t kMin = 16;
  return ending_ >= std::max(kMin, limits_.max / 4);
}

bool Connections::evict_one_locked(std::string_view source) {
  if (is_evicting_enough_locked()) return false;
  const auto victim = victim_locked(source);
  if (victim == entries_.end()) return false;
  end_locked(victim->second);
  ++evicted_;
  return true;
}

// First the oldest that has made no call in time. Then, of TCP and Unix sockets, whichever has more: the oldest without
// a call, or, if all have made one (or cannot be told apart), the oldest of the client with the most. `source`: only
// connections from there; empty: all.
Connections::Entries::iterator Connections::victim_locked(std::string_view source) {
  const auto now = Clock::now();
  size_t open = 0, unix_count = 0;
  Entries::iterator silent[2] = {entries_.end(), entries_.end()};  // by is_unix
  for (auto at = entries_.begin(); at != entries_.end(); ++at) {
    const Entry& entry = at->second;
    if (entry.is_ending || (!source.empty() && entry.peer.source != source)) continue;
    ++open;
    unix_count += entry.peer.is_unix;
    const bool is_silent = entry.peer.is_unix ? !entry.is_handed_over : entry.client.empty();
    auto& oldest = silent[entry.peer.is_unix];
    if (is_silent && oldest == entries_.end()) oldest = at;
  }
  for (const auto oldest : silent)
    if (oldest != entries_.end() && now - oldest->second.begin > kTimeForFirstCall) return oldest;
  const bool is_unix = 2 * unix_count > open;
  return silent[is_unix] != entries_.end() ? silent[is_unix] : oldest_of_largest_group_locked(source, is_unix);
}

Connections::Entries::iterator Connections::oldest_of_largest_group_locked(std::string_view source, bool is_unix) {
  struct Group {
    size_t count = 0;
    Entries::iterator oldest;
  };
  std::unordered_map<std::string, Group> groups;
  const Group* largest = nullptr;
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    const Entry& one = entry->second;
    if (one.is_ending || one.peer.is_unix != is_unix || (!source.empty() && one.peer.source != source)) continue;
    Group& group = groups[one.client + "@" + one.peer.source];
    if (group.count++ == 0) group.oldest = entry;
    if (!largest || group.count > largest->count) largest = &group;
  }
  return largest ? largest->oldest : entries_.end();
}

// Through a duplicate, which still refers to the same socket if the owner closes its own now and the number is reused.
void Connections::end_locked(Entry& entry) const {
  if (entry.is_ending) return;
  entry.is_ending = true;
  ++ending_;
  const Fd same(fcntl(entry.socket, F_DUPFD_CLOEXEC, 0));
  const int fd = same ? same.get() : entry.socket;  // if no descriptor is left
  if (inode_of(fd) == entry.inode) shutdown(fd, SHUT_RDWR);
}

}  // namespace collided::server
