#pragma once
// What the sockets alone cost: a child process that takes bytes, waits for as long as it is told, and gives bytes back,
// over loopback TCP (TCP_NODELAY) and over a Unix stream.

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <vector>

namespace collided::cli {

struct Exchange {
  size_t up = 0, down = 0;  ///< bytes
  double hold_ms = 0;       ///< the peer sleeps so long before it answers
};

class EchoPeer {
 public:
  /// Starts the child; before any thread, because it is a copy of this process. Throws std::system_error.
  EchoPeer();
  EchoPeer(const EchoPeer&) = delete;
  EchoPeer& operator=(const EchoPeer&) = delete;
  ~EchoPeer();

  /// Milliseconds from the first byte up to the last byte down, less those that the peer slept. Throws
  /// std::system_error.
  double tcp_ms(const Exchange& what) { return exchange(tcp_, what); }
  double unix_ms(const Exchange& what) { return exchange(unix_, what); }

 private:
  double exchange(int socket, const Exchange& what);
  void close_sockets();

  int tcp_ = -1, unix_ = -1;
  pid_t pid_ = -1;
  std::vector<char> bytes_;
};

}  // namespace collided::cli
