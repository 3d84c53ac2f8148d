// Metrics and health over a real socket.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>
#include <vector>

#include "server/ops/http_server.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {
namespace {

class Http : public testing::Test {
 protected:
  // What the server answers to these bytes until it closes the connection.
  std::string exchange(const std::string& request) const {
    const auto& address = server_.address();
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_EQ(connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof(to)), 0);
    EXPECT_GE(send(socket, request.data(), request.size(), MSG_NOSIGNAL), 0);
    std::string answer(1 << 20, '\0');
    size_t size = 0;
    for (ssize_t got; (got = recv(socket, answer.data() + size, answer.size() - size, 0)) > 0;) size += got;
    close(socket);
    answer.resize(size);
    return answer;
  }
  std::string request(const std::string& method, const std::string& path) const {
    return exchange(method + " " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  std::string get(const std::string& path) const { return request("GET", path); }

  Metrics metrics_;
  Lifecycle lifecycle_;
  HttpServer server_{"127.0.0.1:0", metrics_, lifecycle_};
};

TEST_F(Http, ReadinessFollowsTheLifecycle) {
  EXPECT_TRUE(get("/readyz").starts_with("HTTP/1.1 503 ")) << get("/readyz");
  lifecycle_.serve();
  EXPECT_TRUE(get("/readyz").starts_with("HTTP/1.1 200 OK\r\n"));
  EXPECT_TRUE(get("/readyz").ends_with("\r\n\r\nready\n"));
  lifecycle_.drain();
  EXPECT_TRUE(get("/readyz").starts_with("HTTP/1.1 503 "));
  EXPECT_TRUE(get("/readyz").ends_with("draining\n"));
  lifecycle_.fail("device 0");
  EXPECT_TRUE(get("/readyz").ends_with("failed: device 0\n"));
  EXPECT_TRUE(get("/healthz").starts_with("HTTP/1.1 200 "));
}

TEST_F(Http, Metrics) {
  const auto answer = get("/metrics");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 200 "));
  EXPECT_NE(answer.find("Content-Type: text/plain; version=0.0.4"), std::string::npos);
  EXPECT_NE(answer.find("\ncollided_frames_total 0\n"), std::string::npos);
}

TEST_F(Http, OtherPathsAndMethods) {
  EXPECT_TRUE(get("/").starts_with("HTTP/1.1 404 "));
  EXPECT_TRUE(get("/metrics/more").starts_with("HTTP/1.1 404 "));
  EXPECT_TRUE(get("/../etc/passwd").starts_with("HTTP/1.1 404 "));
  for (const auto* method : {"POST", "PUT", "DELETE", "OPTIONS"})
    EXPECT_TRUE(request(method, "/metrics").starts_with("HTTP/1.1 405 ")) << method << request(method, "/metrics");
  const auto head = request("HEAD", "/healthz");
  EXPECT_TRUE(head.starts_with("HTTP/1.1 200 "));
  EXPECT_TRUE(head.ends_with("\r\n\r\n"));
}

TEST_F(Http, OutlivesHostileRequests) {
  lifecycle_.serve();
  for (const auto& bytes :
       {std::string("\0\0\0\0\r\n\r\n", 8), std::string("GET\r\n\r\n"),
        "GET /" + std::string(100'000, 'a') + "\r\n\r\n",
        "GET / HTTP/1.1\r\nX: " + std::string(100'000, 'b') + "\r\n\r\n",
        std::string("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
        std::string("POST /metrics HTTP/1.1\r\nHost: a\r\nContent-Length: -5\r\n\r\n"),
        std::string("GET /metrics HTTP/9.9\r\n\r\n"), std::string("BREW /metrics HTTP/1.1\r\nHost: a\r\n\r\n")})
    EXPECT_FALSE(exchange(bytes).starts_with("HTTP/1.1 200")) << bytes.substr(0, 40);
  EXPECT_TRUE(get("/readyz").starts_with("HTTP/1.1 200 "));
}

TEST_F(Http, ManyAtOnce) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 10; ++i) EXPECT_TRUE(get("/metrics").starts_with("HTTP/1.1 200 "));
    });
  for (auto& thread : threads) thread.join();
}

TEST_F(Http, AnAddressInUseIsRefusedByName) {
  try {
    HttpServer(server_.address(), metrics_, lifecycle_);
    FAIL() << "bound twice";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(server_.address()), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace collided::server
