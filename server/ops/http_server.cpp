// Metrics and health over plain HTTP. Sockets, threads and parsing are civetweb's.
#include "server/ops/http_server.hpp"

#include <civetweb.h>

#include <chrono>
#include <future>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "server/ops/lifecycle.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {
namespace {

struct Answer {
  int code = 200;
  std::string text;
  const char* type = "text/plain; charset=utf-8";
};

const char* phrase(int code) {
  switch (code) {
    case 200:
      return "OK";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    default:
      return "Service Unavailable";
  }
}

Answer readiness(const Lifecycle& lifecycle) {
  const auto status = lifecycle.status();
  return {status.state == Lifecycle::State::kServing ? 200 : 503, status.text() + "\n"};
}

void send(mg_connection* connection, const Answer& answer, bool head) {
  mg_printf(connection, "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\n%sConnection: close\r\n\r\n",
            answer.code, phrase(answer.code), answer.type, answer.text.size(),
            answer.code == 405 ? "Allow: GET, HEAD\r\n" : "");
  if (!head) mg_write(connection, answer.text.data(), answer.text.size());
}

struct Library {
  Library() { mg_init_library(0); }
  ~Library() { mg_exit_library(); }
};

}  // namespace

struct HttpServer::Handlers {
  const Metrics& metrics;
  const Lifecycle& lifecycle;
  const Library library{};
  std::unique_ptr<mg_context, decltype(&mg_stop)> context{nullptr, mg_stop};

  Answer answer(std::string_view path) const {
    if (path == "/metrics") return {200, metrics.text(), "text/plain; version=0.0.4; charset=utf-8"};
    if (path == "/readyz") return readiness(lifecycle);
    if (path == "/healthz") return {200, "alive\n"};
    return {404, "not found\n"};
  }

  // civetweb looks every 2 s whether it is to stop, and after each connection: so it gets one.
  void stop(const std::string& address) {
    const auto colon = address.rfind(':');
    const bool v6 = address.starts_with('[');
    const auto host = v6 ? address.substr(1, colon - 2) : address.substr(0, colon);
    const auto stopped = std::async(std::launch::async, [this] { context.reset(); });
    while (stopped.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
      char error[128];
      mg_close_connection(
          mg_connect_client(host.c_str(), std::stoi(address.substr(colon + 1)), false, error, sizeof(error)));
    }
  }

  // What a handler throws would end civetweb's C thread, and with it the daemon.
  static int handle(mg_connection* connection, void* self) try {
    const auto* request = mg_get_request_info(connection);
    const std::string_view method = request->request_method, path = request->local_uri;
    const bool head = method == "HEAD";
    if (head || method == "GET") {
      send(connection, static_cast<const Handlers*>(self)->answer(path), head);
    } else {
      send(connection, {405, "only GET and HEAD\n"}, false);
    }
    return 1;
  } catch (const std::exception&) {
    send(connection, {503, "the daemon could not answer\n"}, false);
    return 1;
  }
};

HttpServer::HttpServer(const std::string& address, const Metrics& metrics, const Lifecycle& lifecycle)
    : handlers_(new Handlers{metrics, lifecycle}) {
  // clang-format off
  const char* options[] = {
      "listening_ports", address.c_str(), "num_threads", "8", "request_timeout_ms", "2000",
      "max_request_size", "8192", "enable_keep_alive", "no", nullptr};
  // clang-format on
  mg_callbacks callbacks{};
  callbacks.log_message = [](const mg_connection*, const char*) { return 1; };  // else civetweb writes to stderr
  handlers_->context.reset(mg_start(&callbacks, nullptr, options));
  mg_server_port port{};
  if (!handlers_->context || mg_get_server_ports(handlers_->context.get(), 1, &port) != 1)
    throw std::runtime_error("--http-address " + address + ": cannot listen there");
  mg_set_request_handler(handlers_->context.get(), "**", Handlers::handle, handlers_.get());
  address_ = address.substr(0, address.rfind(':') + 1) + std::to_string(port.port);
}

HttpServer::~HttpServer() { handlers_->stop(address_); }

}  // namespace collided::server
