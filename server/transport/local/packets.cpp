// Packets of a SOCK_SEQPACKET socket, and the files that come with them.
#include "server/transport/local/packets.hpp"

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr size_t kMaxFiles = 253;     // the kernel's own limit; it would close files that do not fit on this thread
constexpr size_t kExpectedFiles = 4;  // lenient: a valid client sends one

std::vector<PassedFile> files_of(msghdr& message) {
  std::vector<PassedFile> files;
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS) continue;
    const size_t count = (part->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(part) + i * sizeof(int), sizeof(int));
      files.emplace_back(fd);
    }
  }
  return files;
}

// A shortage must not look like the client's own end of the stream.
Packet nothing_because(int error) {
  if (error == EAGAIN || error == EINTR) return {};
  if (error == ECONNRESET || error == ENOTCONN) return {Arrival::kGone, {}, {}};
  throw std::system_error(error, std::generic_category(), "recvmsg");
}

// An empty packet looks like the end of the connection.
bool is_end(int socket) {
  pollfd state{socket, POLLRDHUP, 0};
  return poll(&state, 1, 0) != 0;  // an interrupted one proves no packet
}

}  // namespace

Packet PacketReceiver::receive() {
  alignas(cmsghdr) char control[CMSG_SPACE(kMaxFiles * sizeof(int))];
  iovec bytes{buffer_.data(), buffer_.size()};
  msghdr message{};
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof(control);
  const ssize_t size = recvmsg(socket_, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (size < 0) return nothing_because(errno);
  Packet packet{Arrival::kPacket, {buffer_.data(), static_cast<size_t>(size)}, files_of(message)};
  if (message.msg_flags & MSG_CTRUNC)
    throw LimitExceeded("packet", "packet has more files than the daemon has file descriptors left for");
  if (packet.files.size() > kExpectedFiles)
    throw LimitExceeded("packet",
                        fmt::format("packet has more than {} files, but at most one is allowed", kExpectedFiles));
  if (message.msg_flags & MSG_TRUNC)
    throw LimitExceeded("packet", fmt::format("packet is longer than {} bytes, the limit", v1::kMaxPacketBytes));
  if (size > 0) return packet;
  if (!is_end(socket_)) throw InvalidInput("packet", "packet is empty, but each is one message");
  return {Arrival::kEnd, {}, {}};
}

Sent send_packet(int socket, std::string_view packet) {
  if (send(socket, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return Sent::kYes;
  if (errno == EAGAIN || errno == EINTR) return Sent::kFull;
  return errno == ENOBUFS || errno == ENOMEM ? Sent::kShort : Sent::kGone;
}

void end_connection(Fd socket) {
  if (!socket) return;
  shutdown(socket.get(), SHUT_RDWR);  // the other end notices now, however long closing takes
  close_in_background(std::move(socket));
}

}  // namespace collided::server
