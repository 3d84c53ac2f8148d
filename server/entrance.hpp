#pragma once
// How clients reach the gRPC server: through our own sockets, whose connections are handed to it. gRPC's own listener
// stops for good once accept() fails for lack of a descriptor, and limits neither connections nor their silence.

#include <grpcpp/grpcpp.h>

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/auth/certificate_watch.hpp"
#include "server/auth/credentials.hpp"
#include "server/builtin/health.hpp"
#include "server/config/config.hpp"
#include "server/limits/unaccepted_calls.hpp"
#include "server/net/accept_loop.hpp"
#include "server/net/admission_probe.hpp"
#include "server/net/connections.hpp"
#include "server/net/sockets/listener.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {

class Entrance {
 public:
  /// Binds the addresses. Throws ConfigError for unusable TLS files, std::runtime_error that names the address and the
  /// reason. `metrics` must outlive it.
  Entrance(const Config& config, Metrics& metrics);

  /// Before the server is built. The server must be destroyed before the entrance is. A connection may have `max_calls`
  /// open.
  void add_to(grpc::ServerBuilder& builder, size_t max_calls);
  /// For each call that is accepted.
  void accepted(const grpc::ServerContextBase& context);
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
  /// gRPC's end of the listeners of one kind.
  struct Gate {
    std::shared_ptr<grpc::ServerCredentials> credentials;
    std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor;
  };
  /// A gate for the Unix sockets of one user: gRPC does not tell a call's user, but which gate it came through.
  struct UserGate {
    std::optional<uid_t> user = {};  // set by the accepting thread, before gRPC has a connection of the gate
    Gate gate = {};
  };
  struct Socket {
    int fd = -1;
    const Gate* gate = nullptr;
  };

  void take(Fd connection, size_t place);
  const Gate& gate_of(const Fd& connection, size_t place);

  std::vector<Listener> listeners_;
  std::optional<CertificateWatch> tls_;
  Connections connections_;
  std::optional<UnacceptedCalls> unaccepted_;
  std::vector<Socket> sockets_;
  Gate unix_, tcp_;
  std::deque<UserGate> users_;  // of the Unix sockets
  std::optional<AcceptLoop> loop_;
  std::optional<AdmissionProbe> probe_;
};

}  // namespace collided::server
