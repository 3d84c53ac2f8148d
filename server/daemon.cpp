// The gRPC server around the service.
#include "server/daemon.hpp"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <stdexcept>

#include "gpu/detector.hpp"
#include "server/service/service.hpp"

namespace collided::server {
namespace {

constexpr int kPingMs = 10'000, kPingTimeoutMs = 5'000, kMinPingIntervalMs = 5'000;
constexpr auto kLastAnswers = std::chrono::milliseconds(100);  // for answers on their way out

// A killed peer is seen at once, a cut-off one only by pings; clients may ping on idle streams, too.
void set_keepalive(grpc::ServerBuilder& builder) {
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kPingMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kPingTimeoutMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kMinPingIntervalMs);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
}

std::string bound_address(const std::string& wanted, int port) {
  if (wanted.starts_with("unix:")) return wanted;
  return wanted.substr(0, wanted.rfind(':') + 1) + std::to_string(port);
}

// Whether somebody accepts connections on a Unix socket. Does not wait: a full backlog (EAGAIN) is an answer, too.
bool is_served(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (probe < 0) return false;
  const bool served =
      connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 || errno == EAGAIN;
  close(probe);
  return served;
}

// gRPC removes a socket that is in its way, without asking whether a daemon still serves there.
void check_free(const std::string& address) {
  if (address.starts_with("unix:") && is_served(address.substr(5)))
    throw std::runtime_error("cannot listen on " + address + ": another daemon serves there");
}

}  // namespace

Daemon::Daemon(const Config& config) {
  if (config.backend == "cuda" && !cuda_available())
    throw std::runtime_error("--backend is cuda, but there is no usable CUDA device");
  for (const auto& address : config.addresses) check_free(address);
  service_ = std::make_unique<CollisionService>(config);
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  // Two daemons on one port would share its connections by chance.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.SetMaxReceiveMessageSize(static_cast<int>(config.limits.max_message_bytes));
  set_keepalive(builder);
  std::vector<int> ports(config.addresses.size(), 0);
  for (size_t i = 0; i < ports.size(); ++i)
    builder.AddListeningPort(config.addresses[i], grpc::InsecureServerCredentials(), &ports[i]);
  builder.RegisterService(service_.get());
  server_ = builder.BuildAndStart();
  for (size_t i = 0; i < ports.size(); ++i) {
    if (!server_ || ports[i] == 0) throw std::runtime_error("cannot listen on " + config.addresses[i]);
    addresses_.push_back(bound_address(config.addresses[i], ports[i]));
  }
  server_->GetHealthCheckService()->SetServingStatus(pb::CollisionService::service_full_name(), true);
}

Daemon::~Daemon() { stop(0); }

void Daemon::stop(double grace_seconds) {
  if (!server_) return;
  server_->GetHealthCheckService()->SetServingStatus(false);
  service_->announce_stop(grace_seconds);
  const auto grace =
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(grace_seconds));
  const bool idle = service_->wait_idle(std::chrono::steady_clock::now() + grace);
  // Shutdown also waits for idle connections, which some clients never close: hence not the whole grace again.
  server_->Shutdown(std::chrono::system_clock::now() + (idle ? kLastAnswers : std::chrono::milliseconds(0)));
  server_->Wait();
  service_->clear();
  server_.reset();
}

}  // namespace collided::server
