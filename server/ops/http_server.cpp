// Metrics and health over plain HTTP. libmicrohttpd serves requests on one thread that blocks on no client; connections
// are accepted and evicted here.
#include "server/ops/http_server.hpp"

#include <microhttpd.h>
#include <sys/socket.h>

#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "server/net/accept_loop.hpp"
#include "server/net/connections.hpp"
#include "server/net/sockets/listener.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {
namespace {

constexpr size_t kMaxConnections = 128;  // a new one evicts the oldest
constexpr unsigned kSilentSeconds = 3;
constexpr size_t kConnectionBytes = 16 << 10;

struct Answer {
  unsigned code = 200;
  std::string text;
  const char* type = "text/plain; charset=utf-8";
};

Answer readiness(const Lifecycle& lifecycle) {
  const auto status = lifecycle.status();
  return {status.ready() ? 200u : 503u, status.text() + "\n"};
}

MHD_Result send(MHD_Connection* connection, Answer answer) {
  MHD_Response* const response =
      MHD_create_response_from_buffer(answer.text.size(), answer.text.data(), MHD_RESPMEM_MUST_COPY);
  if (!response) return MHD_NO;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, answer.type);
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONNECTION, "close");
  if (answer.code == MHD_HTTP_METHOD_NOT_ALLOWED) MHD_add_response_header(response, MHD_HTTP_HEADER_ALLOW, "GET, HEAD");
  const MHD_Result queued = MHD_queue_response(connection, answer.code, response);
  MHD_destroy_response(response);
  return queued;
}

}  // namespace

struct HttpServer::Parts {
  Parts(const std::string& address, const Metrics& metrics, const Lifecycle& lifecycle)
      : metrics(metrics), lifecycle(lifecycle), listener(address), http(start(), MHD_stop_daemon) {
    if (!http) throw std::runtime_error("cannot serve HTTP on " + address);
    loop.emplace(listener.sockets(), connections, [this](Fd socket, size_t) { take(std::move(socket)); });
  }

  Answer answer(std::string_view path) const {
    if (path == "/metrics") return {200, metrics.text(), "text/plain; version=0.0.4; charset=utf-8"};
    if (path == "/readyz") return readiness(lifecycle);
    if (path == "/healthz") return {200, "alive\n"};
    return {404, "not found\n"};
  }

  Answer answer(std::string_view path, std::string_view method, std::string_view version) const {
    if (version != MHD_HTTP_VERSION_1_0 && version != MHD_HTTP_VERSION_1_1) return {400, "only HTTP/1\n"};
    if (method != MHD_HTTP_METHOD_GET && method != MHD_HTTP_METHOD_HEAD) return {405, "only GET and HEAD\n"};
    return answer(path);
  }

  // An exception would escape the library's C thread and end the daemon.
  static MHD_Result handle(void* self, MHD_Connection* connection, const char* path, const char* method,
                           const char* version, const char*, size_t*, void**) try {
    return send(connection, static_cast<const Parts*>(self)->answer(path, method, version));
  } catch (const std::exception&) {
    return send(connection, {503, "the daemon could not answer\n"});
  }

  MHD_Daemon* start() {
    return MHD_start_daemon(MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_NO_LISTEN_SOCKET | MHD_USE_ITC, 0, nullptr, nullptr,
                            handle, this, MHD_OPTION_CONNECTION_LIMIT, static_cast<unsigned>(2 * kMaxConnections),
                            MHD_OPTION_CONNECTION_TIMEOUT, kSilentSeconds, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
                            kConnectionBytes, MHD_OPTION_END);
  }

  // The library closes the socket in any case.
  void take(Fd socket) {
    sockaddr_storage address{};
    socklen_t size = sizeof(address);
    getpeername(socket.get(), reinterpret_cast<sockaddr*>(&address), &size);
    MHD_add_connection(http.get(), socket.release(), reinterpret_cast<const sockaddr*>(&address), size);
  }

  const Metrics& metrics;
  const Lifecycle& lifecycle;
  const Listener listener;
  Connections connections{{kMaxConnections, kMaxConnections}};
  const std::unique_ptr<MHD_Daemon, decltype(&MHD_stop_daemon)> http;
  std::optional<AcceptLoop> loop;
};

HttpServer::HttpServer(const std::string& address, const Metrics& metrics, const Lifecycle& lifecycle)
    : parts_(std::make_unique<Parts>(address, metrics, lifecycle)) {}

HttpServer::~HttpServer() = default;

const std::string& HttpServer::address() const { return parts_->listener.address(); }

}  // namespace collided::server
