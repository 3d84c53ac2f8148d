// The table of accepted connections, which others close.
#include "server/net/connections.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>

#include "server/net/sockets/fd.hpp"
#include "server/net/unread_resets.hpp"

namespace collided::server {
namespace {

// An honest client makes its first call at once; gRPC allows the same time for the handshake.
constexpr auto kTimeForFirstCall = std::chrono::seconds(10);
constexpr auto kCountedTime = std::chrono::seconds(10), kRefusal = std::chrono::seconds(2);
constexpr uint32_t kMaxAbandoned = 1000;  // of a source
constexpr uint32_t kMinAbandoned = 20;    // of a connection, before it is ended for its source's count
constexpr uint32_t kCheckEvery = 64;      // abandoned calls over Unix sockets between two searches for the culprit
constexpr std::string_view kUnix = "unix";
constexpr size_t kSweepEvery = 64;  // connections between two sweeps

ino_t inode_of(int fd) {
  struct stat file {};
  return fstat(fd, &file) == 0 && S_ISSOCK(file.st_mode) ? file.st_ino : 0;
}

}  // namespace

Connections::Entry::Entry(int connection, const Peer& other)
    : socket(connection),
      inode(inode_of(connection)),
      peer(other),
      meter(other.is_unix ? nullptr : std::make_unique<FloodMeter>(begin)) {}

void Connections::set_limit(size_t max) {
  const std::lock_guard lock(mutex_);
  max_ = max;
}

bool Connections::may_accept() {
  const std::lock_guard lock(mutex_);
  if (open_locked() < max_ || !is_evicting_enough_locked()) return true;
  sweep_locked();
  return open_locked() < max_ || !is_evicting_enough_locked();
}

bool Connections::admit(int socket, const Peer& peer) {
  const std::lock_guard lock(mutex_);
  if (is_refused_locked(peer.source)) return false;
  if (next_ % kSweepEvery == 0 || open_locked() >= max_) sweep_locked();
  while (open_locked() >= max_ && make_room_locked()) continue;
  const uint64_t id = next_++;
  entries_.try_emplace(id, socket, peer);
  if (!peer.is_unix) by_peer_[peer.name] = id;
  return true;
}

void Connections::identified(std::string_view peer, std::string_view client) {
  const std::lock_guard lock(mutex_);
  Entry* const entry = find_locked(peer);
  if (entry && entry->client != client) entry->client = client;
}

void Connections::began(std::string_view peer) {
  const std::lock_guard lock(mutex_);
  if (Entry* const entry = find_locked(peer)) entry->meter->began();
}

void Connections::ended(std::string_view peer) {
  const std::lock_guard lock(mutex_);
  if (Entry* const entry = find_locked(peer)) entry->meter->ended();
}

void Connections::received(std::string_view peer, uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (Entry* const entry = find_locked(peer)) entry->meter->received(bytes);
}

void Connections::sent(std::string_view peer, uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (Entry* const entry = find_locked(peer)) entry->meter->sent(bytes);
}

Connections::Entry* Connections::find_locked(std::string_view peer) {
  const auto found = by_peer_.find(peer);
  return found == by_peer_.end() ? nullptr : &entries_.at(found->second);
}

bool Connections::abandoned(std::string_view peer) {
  const std::lock_guard lock(mutex_);
  if (peer.starts_with(kUnix)) return abandoned_over_unix_locked();
  Entry* const entry = find_locked(peer);
  if (!entry) return false;
  ++entry->abandoned;
  const bool is_flood = ++source_locked(entry->peer.source).abandoned >= kMaxAbandoned;
  if (!is_flood || entry->abandoned < kMinAbandoned || entry->is_ending) return false;
  shut_out_locked(*entry);
  return true;
}

// gRPC does not say which connection it was. A flood that outpaces the daemon shows in the unread bytes.
bool Connections::abandoned_over_unix_locked() {
  const uint32_t count = ++source_locked(std::string(kUnix)).abandoned;
  if (count < kMaxAbandoned || count % kCheckEvery != 0) return false;
  const auto found = most_resetting_locked();
  if (found == entries_.end()) return false;
  shut_out_locked(found->second);
  return true;
}

Connections::Entries::iterator Connections::most_resetting_locked() {
  sweep_locked();
  auto found = entries_.end();
  size_t max = kMinAbandoned - 1;
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (!entry->second.peer.is_unix || entry->second.is_ending) continue;
    const size_t resets = count_unread_resets(entry->second.socket);
    if (resets > max) found = entry;
    max = std::max(max, resets);
  }
  return found;
}

std::vector<EndedFlood> Connections::end_floods() {
  std::vector<Watched> watched = prepare_looks();
  // Not under the lock, which each message needs, too.
  for (Watched& one : watched) {
    one.traffic = traffic_of(one.socket);
    one.is_open = inode_of(one.socket) == one.inode;  // checked last: the number may have become another socket's
  }
  std::vector<EndedFlood> ended;
  const auto now = Clock::now();
  const std::lock_guard lock(mutex_);
  for (const Watched& one : watched) {
    const auto found = entries_.find(one.id);
    if (found == entries_.end() || found->second.is_ending) continue;
    if (!one.is_open) {
      erase_locked(found);
      continue;
    }
    Entry& entry = found->second;
    if (!one.traffic) continue;
    const std::string_view what = entry.meter->look(*one.traffic, now, !entry.client.empty());
    if (!what.empty()) ended.push_back(end_flood_locked(entry, what));
  }
  end_unfinished_locked(ended);
  return ended;
}

std::vector<Connections::Watched> Connections::prepare_looks() {
  std::vector<Watched> watched;
  const std::lock_guard lock(mutex_);
  for (auto& [id, entry] : entries_) {
    if (!entry.meter || entry.is_ending) continue;
    entry.meter->prepare_look();
    watched.push_back({id, entry.socket, entry.inode});
  }
  return watched;
}

// Beyond gRPC's quota, which is for all, it resets whatever streams it finds. What one client holds of it may be spread
// over connections.
void Connections::end_unfinished_locked(std::vector<EndedFlood>& ended) {
  struct Held {
    uint64_t bytes = 0;
    Entry* most = nullptr;
  };
  std::unordered_map<std::string, Held> clients;
  for (auto& [id, entry] : entries_) {
    if (entry.is_ending || !entry.meter || entry.meter->unfinished() == 0) continue;
    Held& held = clients[entry.client + "@" + entry.peer.source];
    held.bytes += entry.meter->unfinished();
    if (!held.most || entry.meter->unfinished() > held.most->meter->unfinished()) held.most = &entry;
  }
  for (const auto& [client, held] : clients)
    if (held.bytes > max_unfinished_) ended.push_back(end_flood_locked(*held.most, "bytes without a whole message"));
}

EndedFlood Connections::end_flood_locked(Entry& entry, std::string_view what) {
  shut_out_locked(entry);
  ++evicted_;
  return {entry.peer.name, entry.client, what};
}

void Connections::shut_out_locked(Entry& entry) {
  source_locked(entry.peer.source).refused_until = Clock::now() + kRefusal;
  end_locked(entry);
}

bool Connections::is_refused_locked(const std::string& source) const {
  const auto found = sources_.find(source);
  return found != sources_.end() && Clock::now() < found->second.refused_until;
}

// Forgets sources whose counting period is over.
Connections::Source& Connections::source_locked(const std::string& name) {
  const auto now = Clock::now();
  Source& source = sources_[name];
  if (now - source.begin < kCountedTime) return source;
  std::erase_if(sources_, [&](const auto& one) { return now - one.second.begin >= kCountedTime; });
  return sources_[name];
}

void Connections::evict(size_t count) {
  const std::lock_guard lock(mutex_);
  sweep_locked();
  while (count-- > 0 && make_room_locked()) continue;
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

// An evicted connection keeps its descriptor until its owner notices, so their number is limited.
bool Connections::is_evicting_enough_locked() const {
  constexpr size_t kMin = 16;
  return ending_ >= std::max(kMin, max_ / 4);
}

bool Connections::make_room_locked() {
  if (is_evicting_enough_locked()) return false;
  const auto victim = victim_locked();
  if (victim == entries_.end()) return false;
  end_locked(victim->second);
  ++evicted_;
  return true;
}

// First the oldest that has made no call in time. Then, of TCP and Unix sockets, whichever has more: the oldest without
// a call, or, if all have made one (or cannot be told apart), the oldest of the client with the most.
Connections::Entries::iterator Connections::victim_locked() {
  const auto now = Clock::now();
  size_t unix_count = 0;
  auto silent = entries_.end();
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->second.is_ending) continue;
    unix_count += entry->second.peer.is_unix;
    const bool is_silent = !entry->second.peer.is_unix && entry->second.client.empty();
    if (is_silent && silent == entries_.end()) silent = entry;
  }
  if (silent != entries_.end() && now - silent->second.begin > kTimeForFirstCall) return silent;
  const bool is_unix = 2 * unix_count > open_locked();
  return !is_unix && silent != entries_.end() ? silent : oldest_of_largest_group_locked(is_unix);
}

Connections::Entries::iterator Connections::oldest_of_largest_group_locked(bool is_unix) {
  struct Group {
    size_t count = 0;
    Entries::iterator oldest;
  };
  std::unordered_map<std::string, Group> groups;
  const Group* largest = nullptr;
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    const Entry& one = entry->second;
    if (one.is_ending || one.peer.is_unix != is_unix) continue;
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
