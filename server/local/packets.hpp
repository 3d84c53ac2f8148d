#pragma once
// Packets of a SOCK_SEQPACKET socket, and the files that come with them. Nothing here waits.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "server/local/disposal.hpp"

namespace collided::server {

constexpr size_t kMaxPacketBytes = size_t{64} << 10;

/// What receive() found.
enum class Arrival { kPacket, kNothing, kEnd };

struct Packet {
  Arrival arrival = Arrival::kNothing;
  std::string_view bytes;  ///< until the next packet is received
  std::vector<PassedFile> files;
};

class PacketReceiver {
 public:
  /// The socket outlives the receiver.
  explicit PacketReceiver(int socket) : socket_(socket), buffer_(kMaxPacketBytes, '\0') {}

  /// kEnd: the other end sends nothing any more, or is gone. Throws LimitExceeded for a packet that is too long or has
  /// too many files, all of which are closed by then, InvalidInput for an empty one.
  Packet receive();

 private:
  const int socket_;
  std::string buffer_;
};

/// What became of a packet that was to be sent.
enum class Sent { kYes, kFull, kGone };

Sent send_packet(int socket, std::string_view packet);

/// Closes the socket without waiting. What was sent stays to be read at the other end, which closing a socket with
/// something unread would hide.
void end_connection(Fd socket);

}  // namespace collided::server
