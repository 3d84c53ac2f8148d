#pragma once
// What the sockets alone cost: a child process that takes bytes and gives bytes back, over loopback TCP (TCP_NODELAY)
// and over a Unix stream.

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <vector>

namespace collided::cli {

class EchoPeer {
 public:
  /// Starts the child; before any thread, because it is a copy of this process. Throws std::system_error.
  EchoPeer();
  EchoPeer(const EchoPeer&) = delete;
  EchoPeer& operator=(const EchoPeer&) = delete;
  ~EchoPeer();

  /// Milliseconds from the first byte up to the last byte down. Throws std::system_error.
  double tcp_ms(size_t up, size_t down) { return exchange(tcp_, up, down); }
  double unix_ms(size_t up, size_t down) { return exchange(unix_, up, down); }

 private:
  double exchange(int socket, size_t up, size_t down);
  void close_sockets();

  int tcp_ = -1, unix_ = -1;
  pid_t pid_ = -1;
  std::vector<char> bytes_;
};

}  // namespace collided::cli
