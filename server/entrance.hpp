#pragma once
// How clients reach the gRPC server: through our own sockets, whose connections are handed to it. gRPC's own listener
// stops for good once accept() fails for lack of a descriptor, and limits neither connections nor their silence.

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/auth/certificate_watch.hpp"
#include "server/builtin/health.hpp"
#include "server/config/config.hpp"
#include "server/net/accept_loop.hpp"
#include "server/net/admission_probe.hpp"
#include "server/net/connections.hpp"
#include "server/net/listener.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {

class Entrance {
 public:
  /// Binds the addresses. Throws ConfigError for unusable TLS files, std::runtime_error that names the address and the
  /// reason. `metrics` must outlive it.
  Entrance(const Config& config, Metrics& metrics);

  /// Before the server is built. The server must be destroyed before the entrance is.
  void add_to(grpc::ServerBuilder& builder);
  /// Once the server has started. Reports to `lifecycle` and `health` whatever keeps new clients out.
  void open(Lifecycle& lifecycle, Health& health);
  /// Stops reporting. Clients can still connect.
  void end_probe() { probe_.reset(); }
  /// Accepts no more connections. Before the server's Shutdown.
  void close();

  void set_limit(const Config& config);
  Connections& connections() { return connections_; }
  const Connections& connections() const { return connections_; }
  /// With the ports that the system assigned.
  std::vector<std::string> addresses() const;

 private:
  using Acceptor = std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>;
  struct Socket {
    int fd = -1;
    bool is_tls = false;
  };

  bool is_tls(const Listener& listener) const { return tls_ && !listener.is_unix(); }
  void take(Fd connection, size_t place) const;

  std::vector<Listener> listeners_;
  std::optional<CertificateWatch> tls_;
  std::shared_ptr<grpc::ServerCredentials> credentials_;
  Connections connections_;
  std::vector<Socket> sockets_;
  Acceptor plain_, secure_;
  std::optional<AcceptLoop> loop_;
  std::optional<AdmissionProbe> probe_;
};

}  // namespace collided::server
