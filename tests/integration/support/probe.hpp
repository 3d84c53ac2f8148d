#pragma once
// A daemon observed from outside: its metrics over HTTP, and its memory according to the kernel.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/support/sanitized.hpp"

namespace collided::test {

/// A TCP connection to host:port of this machine, whose reads wait 20 s at most; -1 if there is none.
inline int connect_to(const std::string& address) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  const auto colon = address.rfind(':');
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &to.sin_addr);
  const int socket_fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const timeval most{20, 0};
  setsockopt(socket_fd, SOL_SOCKET, SO_RCVTIMEO, &most, sizeof(most));
  if (connect(socket_fd, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) == 0) return socket_fd;
  close(socket_fd);
  return -1;
}

/// Head and body of the answer; empty if none came.
inline std::string http_get(const std::string& address, const std::string& path) {
  const int connection = connect_to(address);
  if (connection < 0) return {};
  const std::string request = "GET " + path + " HTTP/1.1\r\nHost: " + address + "\r\nConnection: close\r\n\r\n";
  std::string answer;
  if (send(connection, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size())) {
    char buffer[16384];
    for (ssize_t n = 0; (n = recv(connection, buffer, sizeof(buffer), 0)) > 0;) answer.append(buffer, n);
  }
  close(connection);
  return answer;
}

/// Waits until `condition` holds; false if that takes too long.
template <class Condition>
bool holds_within(std::chrono::seconds most, const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + most;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

/// The same; a failure of the test if that takes too long.
template <class Condition>
bool eventually(const std::string& what, const Condition& condition,
                std::chrono::seconds most = std::chrono::seconds(20)) {
  if (holds_within(most, condition)) return true;
  ADD_FAILURE() << what << ": not within " << most.count() << " s";
  return false;
}

class Probe {
 public:
  explicit Probe(const DaemonProcess& daemon) : http_(daemon.http_address()), pid_(daemon.pid()) {}

  /// Value of a metric, named with its labels if it has any; 0 for one that has never been counted.
  double metric(const std::string& name) const {
    const std::string text = http_get(http_, "/metrics");
    EXPECT_TRUE(text.starts_with("HTTP/1.1 200")) << text.substr(0, 80);
    const auto found = text.find("\n" + name + " ");
    return found == std::string::npos ? 0 : std::stod(text.substr(found + name.size() + 2));
  }
  /// Whether health is SERVING, as /readyz tells it.
  bool is_ready() const { return http_get(http_, "/readyz").starts_with("HTTP/1.1 200"); }
  double streams() const { return metric("collided_streams"); }
  double scenes() const { return metric("collided_scenes"); }
  double device_bytes() const { return metric("collided_device_bytes"); }
  double rejected(const std::string& code) const { return metric("collided_rejected_total{reason=\"" + code + "\"}"); }

  /// Waits until it has the value.
  bool becomes(const std::string& name, double value) const {
    return eventually(name + " becomes " + std::to_string(value), [&] { return metric(name) == value; });
  }
  bool streams_become(double count) const { return becomes("collided_streams", count); }
  bool scenes_become(double count) const { return becomes("collided_scenes", count); }

  double resident_bytes() const { return status_bytes("VmRSS:"); }
  /// Its maximum so far.
  double peak_resident_bytes() const { return status_bytes("VmHWM:"); }
  double threads() const { return status("Threads:"); }

 private:
  double status_bytes(const std::string& field) const { return status(field) * 1024; }
  double status(const std::string& field) const {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/status");
    for (std::string line; std::getline(file, line);)
      if (line.starts_with(field)) return std::stod(line.substr(field.size()));
    ADD_FAILURE() << "no " << field << " of process " << pid_;
    return std::numeric_limits<double>::infinity();
  }

  std::string http_;
  pid_t pid_;
};

/// Bytes; sanitizers keep freed memory for a while, and shadow used memory.
constexpr double memory_limit(double mebibytes) {
  return (kIsSanitized ? mebibytes * 8 + 1024 : mebibytes) * (1 << 20);
}

}  // namespace collided::test
