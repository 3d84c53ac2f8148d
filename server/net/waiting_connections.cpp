// Accepted connections that gRPC does not have yet.
#include "server/net/waiting_connections.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/net/sockets/peer.hpp"

namespace collided::server {
namespace {

// As long as gRPC gives a handshake.
constexpr auto kMaxWait = std::chrono::seconds(10);
// For a turn, where many wait: what a storm has left does not keep gRPC busy for longer.
constexpr auto kMaxWaitOfMany = std::chrono::seconds(2);
constexpr size_t kMany = 32;
// Then others have their turn: a busy machine takes long to read.
constexpr auto kMaxTimeUnread = std::chrono::seconds(1);

constexpr short kEnds = POLLRDHUP | POLLHUP | POLLERR | POLLNVAL;

}  // namespace

bool has_left(int socket) {
  pollfd state{socket, POLLRDHUP, 0};
  return poll(&state, 1, 0) > 0;
}

void WaitingConnections::add(Connection connection) { waiting_.push_back(std::move(connection)); }

void WaitingConnections::watch(std::vector<pollfd>& states) const {
  for (const Connection& one : waiting_) {
    const int events = one.has_sent ? POLLRDHUP : POLLIN | POLLRDHUP;
    states.push_back({one.fd.get(), static_cast<short>(events), 0});
  }
}

void WaitingConnections::update(const pollfd* states, Clock::time_point now) {
  const auto max_wait = waiting_.size() > kMany ? kMaxWaitOfMany : kMaxWait;
  std::erase_if(waiting_, [&](Connection& one) {
    const auto events = (states++)->revents;
    one.has_sent |= (events & POLLIN) != 0;
    return (events & kEnds) || now - one.since > (one.has_sent ? max_wait : kMaxWait);
  });
}

WaitingConnections::Connection WaitingConnections::next(Clock::time_point now) {
  if (!may_hand_over(now)) return Connection{Fd(), 0, {}, now};
  // Sources have their turns in the order of their names, beginning after the last one.
  const auto has_earlier_turn = [&](const Connection& a, const Connection& b) {
    if (a.has_sent != b.has_sent) return a.has_sent;
    const bool is_a_over = a.source <= last_, is_b_over = b.source <= last_;
    return is_a_over != is_b_over ? is_b_over : a.source < b.source;
  };
  const auto newest = std::min_element(waiting_.rbegin(), waiting_.rend(), has_earlier_turn);
  if (newest == waiting_.rend() || !newest->has_sent) return Connection{Fd(), 0, {}, now};
  Connection connection = std::move(*newest);
  waiting_.erase(std::next(newest).base());
  last_ = connection.source;
  unread_.push_back({connection.fd.get(), inode_of(connection.fd.get()), now});
  return connection;
}

size_t WaitingConnections::ready() const {
  return static_cast<size_t>(std::ranges::count_if(waiting_, &Connection::has_sent));
}

// What a client that has left had sent is still being worked at until gRPC closes the connection.
bool WaitingConnections::may_hand_over(Clock::time_point now) {
  std::erase_if(unread_, [&](const Unread& one) {
    const bool is_closed = inode_of(one.socket) != one.inode;
    return is_closed || (!has_unread(one.socket) && !has_left(one.socket)) || now - one.since > kMaxTimeUnread;
  });
  return unread_.size() < max_unread_;
}

}  // namespace collided::server
