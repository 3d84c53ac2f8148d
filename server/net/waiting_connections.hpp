#pragma once
// Accepted connections that gRPC does not have yet. gRPC reads whatever it has as fast as it can and keeps each call
// that it finds: 2,000 calls that are reset at once take it a tenth of a second. So it gets only a few connections at a
// time that it has yet to read. Of each source the newest comes first: whoever comes after a storm need not wait until
// gRPC has read all that is left of it.

#include <poll.h>
#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

#include "server/net/sockets/fd.hpp"

namespace collided::server {

/// True if the client has closed its end of the connection.
bool has_left(int socket);

/// For one thread.
class WaitingConnections {
 public:
  using Clock = std::chrono::steady_clock;
  struct Connection {
    Fd fd;
    size_t place = 0;    ///< of its socket in the accept loop's list
    std::string source;  ///< Peer::source
    Clock::time_point since = Clock::now();
    bool has_sent = false;
  };

  /// `max_unread`: connections that gRPC has and has not read yet.
  explicit WaitingConnections(size_t max_unread) : max_unread_(max_unread) {}

  void add(Connection connection);
  /// Appends what to wait for: first bytes, or ends.
  void watch(std::vector<pollfd>& states) const;
  /// Takes the states that watch() appended. Closes connections whose clients have left, or which have waited for 10 s
  /// (2 s for their turn where many wait).
  void update(const pollfd* states, Clock::time_point now = Clock::now());
  /// The next connection, the newest of each source in turns; none (without a descriptor) if all are silent, or if gRPC
  /// has enough to read.
  Connection next(Clock::time_point now = Clock::now());

  /// Connections, and those of them that have sent something.
  size_t size() const { return waiting_.size(); }
  size_t ready() const;

 private:
  /// A connection that gRPC has, which may close it at any time.
  struct Unread {
    int socket = -1;
    ino_t inode = 0;
    Clock::time_point since;
  };

  bool may_hand_over(Clock::time_point now);

  const size_t max_unread_;
  std::vector<Connection> waiting_;  // the oldest first
  std::string last_;                 // source
  std::vector<Unread> unread_;
};

}  // namespace collided::server
