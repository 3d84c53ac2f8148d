// How clients reach the gRPC server.
#include "server/entrance.hpp"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

#include "server/net/sockets/descriptors.hpp"
#include "server/net/sockets/peer.hpp"
#include "server/ops/log.hpp"

namespace collided::server {
namespace {

constexpr int kHandshakeMs = 10'000;     // of TLS, and until a client's first HTTP/2 frame
constexpr int kMaxIdleMs = 10 * 60'000;  // without a call; clients connect again when they need to
constexpr size_t kMinUnaccepted = 512;   // calls of all connections
constexpr size_t kUsers = 8;             // of Unix sockets that are told apart

ConnectionLimits connection_limits(const Config& config) {
  const size_t wanted = config.limits.max_connections, max = connections_for(descriptor_limit(), wanted);
  const size_t of_peer = config.limits.max_connections_per_peer;
  if (wanted > max)
    log_event(spdlog::level::warn, "max-connections exceeds what the limit of file descriptors allows",
              {{"wanted", wanted}, {"connections", max}, {"descriptors", descriptor_limit()}});
  return {max, of_peer ? of_peer : max};
}

std::optional<uid_t> user_of(int socket) try { return peer_uid(socket); } catch (const std::system_error&) {
  return {};
}

void report(const std::string& obstacle, Lifecycle& lifecycle, Health& health) {
  lifecycle.set_obstacle(obstacle);
  health.set_serving(obstacle.empty());
  if (obstacle.empty())
    log_event(spdlog::level::info, "new clients can connect again", {});
  else
    log_event(spdlog::level::err, "not ready", {{"reason", obstacle}});
}

}  // namespace

Entrance::Entrance(const Config& config, Metrics& metrics) : connections_(connection_limits(config)) {
  const std::chrono::duration<double> timeout(config.keepalive_timeout_seconds);
  for (const auto& address : config.addresses)
    listeners_.emplace_back(address).set_user_timeout(std::chrono::ceil<std::chrono::milliseconds>(timeout));
  if (!config.tls.enabled()) return;
  tls_.emplace(config.tls, [&metrics](bool is_taken) { metrics.count_certificate_reload(is_taken); });
}

void Entrance::add_to(grpc::ServerBuilder& builder, size_t max_calls) {
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, kMaxIdleMs);
  unaccepted_.emplace(max_calls, std::max(max_calls, kMinUnaccepted));
  const AdmitCall admit = [this](const void* connection) { return unaccepted_->arrive(connection); };
  tcp_.credentials = tls_ ? make_credentials(*tls_, admit) : make_plain_credentials(admit);
  unix_.credentials = make_plain_credentials(admit);
  using Type = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  std::vector<Gate*> gates{&tcp_, &unix_};
  for (size_t i = 0; i < kUsers; ++i) {
    UserGate& of_user = users_.emplace_back();
    of_user.gate.credentials =
        make_plain_credentials(admit, [&of_user] { return "uid:" + std::to_string(*of_user.user); });
    gates.push_back(&of_user.gate);
  }
  for (Gate* const gate : gates)
    gate->acceptor = builder.experimental().AddExternalConnectionAcceptor(Type::FROM_FD, gate->credentials);
}

void Entrance::accepted(const grpc::ServerContextBase& context) {
  unaccepted_->accept(connection_of(*context.auth_context()));
  if (connections_.called(context.peer()))
    log_event(spdlog::level::warn, "connection ended: it makes call after call without a known caller",
              {{"peer", context.peer()}});
}

void Entrance::open(Lifecycle& lifecycle, Health& health) {
  std::vector<ProbeTarget> targets;
  std::vector<int> fds;
  for (const auto& listener : listeners_)
    for (const int fd : listener.sockets()) {
      sockets_.push_back({fd, listener.is_unix() ? &unix_ : &tcp_});
      targets.push_back({fd, tls_ && !listener.is_unix(), listener.address()});
      fds.push_back(fd);
    }
  loop_.emplace(
      std::move(fds), connections_, [this](Fd connection, size_t place) { take(std::move(connection), place); },
      [this] { return !unaccepted_->is_full(); });
  probe_.emplace(
      std::move(targets), [this] { return loop_->shortage(); },
      [&](const std::string& obstacle) { report(obstacle, lifecycle, health); });
}

// From now on the connection is gRPC's to close.
void Entrance::take(Fd connection, size_t place) {
  const Gate& gate = gate_of(connection, place);
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
  parameters.listener_fd = sockets_[place].fd;
  parameters.fd = connection.release();
  gate.acceptor->HandleNewConnection(&parameters);
}

// Users beyond the first kUsers share one gate.
const Entrance::Gate& Entrance::gate_of(const Fd& connection, size_t place) {
  const Gate& of_socket = *sockets_[place].gate;
  if (&of_socket != &unix_) return of_socket;
  const std::optional<uid_t> user = user_of(connection.get());
  if (!user) return unix_;
  for (UserGate& each : users_) {
    if (!each.user) each.user = user;
    if (*each.user == user) return each.gate;
  }
  return unix_;
}

void Entrance::close() {
  probe_.reset();
  loop_.reset();
}

void Entrance::set_limit(const Config& config) { connections_.set_limits(connection_limits(config)); }

std::vector<std::string> Entrance::addresses() const {
  std::vector<std::string> addresses;
  for (const auto& listener : listeners_) addresses.push_back(listener.address());
  return addresses;
}

}  // namespace collided::server
