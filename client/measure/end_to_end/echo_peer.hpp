#pragma once
// Measures the cost of sockets alone: a child process that receives bytes, waits for a given time and sends bytes back,
// over loopback TCP (TCP_NODELAY) and a Unix stream.

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <vector>

namespace collided::cli {

struct Exchange {
  size_t up = 0, down = 0;  ///< bytes
  double hold_ms = 0;       ///< how long the peer sleeps before it answers
};

class EchoPeer {
 public:
  /// Forks the child, so there must be no other thread yet. Throws std::system_error.
  EchoPeer();
  EchoPeer(const EchoPeer&) = delete;
  EchoPeer& operator=(const EchoPeer&) = delete;
  ~EchoPeer();

  /// Milliseconds from the first byte sent to the last byte received, less the peer's sleep. Throws std::system_error.
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
