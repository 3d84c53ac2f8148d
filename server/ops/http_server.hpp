#pragma once
// Metrics and health over plain HTTP, for Prometheus, load balancers and Kubernetes.

#include <memory>
#include <string>

namespace collided::server {

class Lifecycle;
class Metrics;

/// Slow clients, however many, do not delay others: past 128 connections a new one evicts the oldest. Serves
/// GET and HEAD of /metrics, /readyz (200, or 503 with the reason) and /healthz (200 while the process runs).
class HttpServer {
 public:
  /// `address` is host:port with a numeric host; port 0: any free one. Throws std::runtime_error if it cannot be bound.
  /// Both references must outlive the server.
  HttpServer(const std::string& address, const Metrics& metrics, const Lifecycle& lifecycle);
  ~HttpServer();

  /// With the port that the system assigned.
  const std::string& address() const;

 private:
  struct Parts;

  std::unique_ptr<Parts> parts_;
};

}  // namespace collided::server
