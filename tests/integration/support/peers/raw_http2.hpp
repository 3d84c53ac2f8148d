#pragma once
// A client that speaks HTTP/2 frame by frame, for what no library does.

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "tests/integration/support/probe.hpp"

namespace collided::test {

/// To "unix:/path" or host:port; -1 if there is no connection.
inline int connect_to_any(const std::string& address) {
  constexpr std::string_view kUnix = "unix:";
  if (!address.starts_with(kUnix)) return connect_to(address);
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  address.copy(to.sun_path, sizeof(to.sun_path) - 1, kUnix.size());
  const int socket_fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(socket_fd, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) == 0) return socket_fd;
  close(socket_fd);
  return -1;
}

class RawHttp2 {
 public:
  explicit RawHttp2(const std::string& address) : socket_(connect_to_any(address)) { send(preface()); }
  ~RawHttp2() { close(socket_); }
  RawHttp2(const RawHttp2&) = delete;
  RawHttp2& operator=(const RawHttp2&) = delete;

  /// Begins `count` calls of a method and resets each at once. False if the daemon has ended the connection.
  bool reset_calls(std::string_view path, int count) {
    const uint32_t first = std::exchange(next_, next_ + 2 * static_cast<uint32_t>(count));
    return send(resets(path, count, first));
  }
  /// The bytes of these on a connection of their own, from its preface on.
  static std::string bytes_of_resets(std::string_view path, int count) { return preface() + resets(path, count, 1); }

  /// A whole call, with an empty message. False as above, as of what follows.
  bool call(std::string_view path) {
    const uint32_t stream = std::exchange(next_, next_ + 2);
    return send(frame(kHeaders, kEndHeaders, stream, block(path)) +
                frame(kData, kEndStream, stream, std::string(5, 0)));
  }
  bool send_settings(int count) {
    return send_repeatedly(frame(kSettings, 0, 0, std::string{0, 4, 0, 0, '\xff', '\xff'}), count);
  }
  bool send_priorities(int count) { return send_repeatedly(frame(kPriority, 0, 9, std::string(5, 0)), count); }
  /// Without data, in a call that they begin.
  bool send_empty_data(std::string_view path, int count) {
    if (!open_) {
      open_ = std::exchange(next_, next_ + 2);
      if (!send(frame(kHeaders, kEndHeaders, open_, block(path)))) return false;
    }
    return send_repeatedly(frame(kData, 0, open_, {}), count);
  }
  /// Bytes so far.
  uint64_t sent() const { return sent_; }

 private:
  static constexpr uint8_t kData = 0, kHeaders = 1, kPriority = 2, kReset = 3, kSettings = 4;
  static constexpr uint8_t kEndStream = 1, kEndHeaders = 4;
  static constexpr int kPatienceMs = 20'000;

  static std::string number(uint32_t value) {
    return {static_cast<char>(value >> 24), static_cast<char>(value >> 16), static_cast<char>(value >> 8),
            static_cast<char>(value)};
  }
  static std::string frame(uint8_t type, uint8_t flags, uint32_t stream, const std::string& body) {
    return number(static_cast<uint32_t>(body.size())).substr(1) + static_cast<char>(type) + static_cast<char>(flags) +
           number(stream) + body;
  }
  static std::string text(std::string_view value) { return static_cast<char>(value.size()) + std::string(value); }
  // HPACK literals, without its tables.
  static std::string block(std::string_view path) {
    return "\x83\x86\x04" + text(path) + "\x01" + text("localhost") + "\x0f\x10" + text("application/grpc") +
           std::string(1, '\0') + text("te") + text("trailers");
  }

  static std::string preface() { return "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + frame(kSettings, 0, 0, {}); }
  static std::string resets(std::string_view path, int count, uint32_t first) {
    const std::string headers = block(path), cancel{0, 0, 0, 8};
    std::string bytes;
    for (uint32_t stream = first; stream < first + 2 * static_cast<uint32_t>(count); stream += 2)
      bytes += frame(kHeaders, kEndHeaders, stream, headers) + frame(kReset, 0, stream, cancel);
    return bytes;
  }

  bool send_repeatedly(const std::string& bytes, int count) {
    std::string all;
    for (int i = 0; i < count; ++i) all += bytes;
    return send(all);
  }
  // A daemon that has ended the connection resets it: that is what this detects.
  bool send(const std::string& bytes) {
    for (size_t sent = 0; sent < bytes.size();) {
      const ssize_t now = ::send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (now < 0 && errno != EAGAIN) return false;
      sent += static_cast<size_t>(std::max<ssize_t>(now, 0));
      pollfd state{socket_, POLLIN | POLLOUT, 0};
      if (now < 0 && poll(&state, 1, kPatienceMs) <= 0) return false;
      if (!drain()) return false;
    }
    sent_ += bytes.size();
    return true;
  }
  // False at the end.
  bool drain() const {
    char buffer[1 << 16];
    ssize_t got = 0;
    while ((got = recv(socket_, buffer, sizeof(buffer), MSG_DONTWAIT)) > 0) continue;
    return got < 0 && errno == EAGAIN;
  }

  const int socket_;
  uint32_t next_ = 1, open_ = 0;
  uint64_t sent_ = 0;
};

}  // namespace collided::test
