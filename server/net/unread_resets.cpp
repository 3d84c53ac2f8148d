// Counts the HTTP/2 streams that a client has reset.
#include "server/net/unread_resets.hpp"

#include <sys/socket.h>
#include <sys/types.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace collided::server {

size_t count_unread_resets(int socket) {
  using std::string_view_literals::operator""sv;
  constexpr size_t kMaxBytes = 64 << 10;
  // A frame of 4 bytes, RST_STREAM, no flags; its stream; an error code, which is a small number.
  constexpr auto kHead = "\0\0\4\3\0"sv, kCode = "\0\0\0"sv;
  constexpr size_t kCodeAt = 9;
  std::vector<char> bytes(kMaxBytes);
  const ssize_t size = recv(socket, bytes.data(), bytes.size(), MSG_PEEK | MSG_DONTWAIT);
  const std::string_view unread(bytes.data(), static_cast<size_t>(std::max<ssize_t>(size, 0)));
  size_t count = 0;
  for (size_t at = unread.find(kHead); at != unread.npos; at = unread.find(kHead, at + kHead.size()))
    count += unread.substr(at).substr(std::min(kCodeAt, unread.size() - at), kCode.size()) == kCode;
  return count;
}

}  // namespace collided::server
