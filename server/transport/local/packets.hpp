#pragma once
// Packets of a SOCK_SEQPACKET socket, and the files that come with them. Nothing here blocks.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "proto/constants.hpp"
#include "server/transport/local/disposal.hpp"

namespace collided::server {

/// The result of receive().
enum class Arrival { kPacket, kNothing, kEnd, kGone };

struct Packet {
  Arrival arrival = Arrival::kNothing;
  std::string_view bytes;  ///< valid until the next packet is received
  std::vector<PassedFile> files;
};

class PacketReceiver {
 public:
  /// The socket outlives the receiver.
  explicit PacketReceiver(int socket) : socket_(socket), buffer_(v1::kMaxPacketBytes, '\0') {}

  /// kEnd: the other end will send nothing more. kGone: it is gone. Throws std::system_error if the system is
  /// short of something, LimitExceeded for a packet that is too long or has
  /// too many files, which are then all closed, and InvalidInput for an empty one.
  Packet receive();

 private:
  const int socket_;
  std::string buffer_;
};

/// The result of send_packet(). kShort: the system has no memory for it; poll() does not tell when it has.
enum class Sent { kYes, kFull, kShort, kGone };

Sent send_packet(int socket, std::string_view packet);

/// Closes the socket without waiting. The other end can still read what was sent, unlike after close() on a socket with
/// unread data.
void end_connection(Fd socket);

}  // namespace collided::server
