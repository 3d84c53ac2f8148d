// The gRPC server around the service, the local socket and HTTP.
#include "server/daemon.hpp"

#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <grpcpp/resource_quota.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "server/config/host_limits.hpp"
#include "server/config/memory_limits.hpp"
#include "server/ops/log.hpp"
#include "server/transport/grpc/call_watch.hpp"

namespace collided::server {
namespace {

// Half of what clients are told: the network may bring two pings closer together than they were sent.
constexpr double kMinPingIntervalSeconds = kMinPingSeconds / 2;
constexpr auto kLastAnswers = std::chrono::milliseconds(100);  // for answers in transit

int milliseconds(double seconds) { return static_cast<int>(seconds * 1000); }

// gRPC's errors are mostly its peers': failed handshakes, broken connections.
void log_grpc(gpr_log_func_args* line) {
  log_event(line->severity == GPR_LOG_SEVERITY_ERROR ? spdlog::level::warn : spdlog::level::debug, line->message,
            {{"source", "grpc"}});
}

void set_quota(grpc::ServerBuilder& builder, const Limits& limits) {
  grpc::ResourceQuota quota("collided");
  quota.Resize(network_quota(limits));
  builder.SetResourceQuota(quota);
}

// Such as invalid UTF-8; the client is told, too.
void log_protobuf(google::protobuf::LogLevel, const char*, int, const std::string& message) {
  log_event(spdlog::level::debug, message, {{"source", "protobuf"}});
}

// A killed peer is noticed at once, an unreachable one only by pings; clients may ping on idle streams, too.
void set_keepalive(grpc::ServerBuilder& builder, const Config& config) {
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, milliseconds(config.keepalive_seconds));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, milliseconds(config.keepalive_timeout_seconds));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                             milliseconds(kMinPingIntervalSeconds));
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
}

std::vector<DeviceGauges> gauges_of(const std::vector<DeviceState>& devices) {
  std::vector<DeviceGauges> gauges;
  for (const DeviceState& device : devices)
    gauges.push_back({to_string(device.info.device), device.scenes, device.held_bytes, device.max_bytes,
                      device.free_bytes, device.waiting_frames, device.busy_seconds});
  return gauges;
}

LocalOptions local_options(const Config& config) {
  if (!overcommits_memory())
    throw std::runtime_error(
        "cannot serve --local-socket: vm.overcommit_memory is 2, but must be 0 or 1 for memory that "
        "clients share");
  LocalOptions options{config.local_socket, config.allowed_uids, config.cuda_ipc, {}};
  options.timeouts.take_seconds = config.keepalive_timeout_seconds;
  return options;
}

}  // namespace

Daemon::Daemon(const Config& config, Lifecycle& lifecycle)
    : lifecycle_(lifecycle),
      core_(config, lifecycle),
      reflection_(core_.service.parts(), config.open_reflection),
      health_(core_.service.parts()),
      entrance_(config, core_.metrics) {
  gpr_set_log_function(log_grpc);
  google::protobuf::SetLogHandler(log_protobuf);
  if (!config.http_address.empty())
    http_ = std::make_unique<HttpServer>(config.http_address, core_.metrics, lifecycle_);
  if (!config.local_socket.empty())
    local_ = std::make_unique<LocalServer>(local_options(config), core_.host, core_.authenticator, core_.metrics);
  log_devices();
  listen(config);
  core_.metrics.set_gauges([this] { return gauges(); });
  core_.authenticator.watch([this](std::string_view peer, const ClientIdentity& client) {
    entrance_.connections().identified(peer, client.name);
  });
  health_.set_serving(true);
  entrance_.open(lifecycle_, health_);
  lifecycle_.serve();
}

void Daemon::log_devices() const {
  for (const DeviceState& device : core_.host.devices().state())
    log_event(spdlog::level::info, "device served",
              {{"device", to_string(device.info.device)},
               {"name", device.info.name},
               {"uuid", device.info.uuid},
               {"max_bytes", device.max_bytes},
               {"free_bytes", device.free_bytes}});
  for (const UnusableDevice& device : core_.host.devices().unusable())
    log_event(device.is_absent ? spdlog::level::info : spdlog::level::warn, "a device cannot be used",
              {{"device", device.device ? to_string(*device.device) : "cuda"},
               {"name", device.name},
               {"reason", device.reason}});
}

Gauges Daemon::gauges() const {
  const HostTotals totals = core_.host.totals();
  const Limits limits = core_.host.limits();
  const uint64_t outgoing = calls_->outgoing_bytes() + (local_ ? local_->outgoing_bytes() : 0);
  return {totals.scenes,
          totals.streams,
          totals.watchers,
          core_.service.in_work(),
          totals.device_bytes,
          totals.waiting_frames,
          outgoing,
          entrance_.connections().size(),
          entrance_.connections().evicted(),
          limits.max_scenes,
          limits.max_streams,
          limits.max_device_bytes,
          lifecycle_.status().ready(),
          gauges_of(totals.devices)};
}

void Daemon::listen(const Config& config) {
  grpc::ServerBuilder builder;
  set_quota(builder, config.limits);
  set_keepalive(builder, config);
  const uint32_t max_calls = max_calls_of_connection(config.limits);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, static_cast<int>(max_calls));
  entrance_.add_to(builder, max_calls);
  core_.add_to(builder);
  health_.add_to(core_.router, pb::CollisionService::service_full_name());
  reflection_.add_to(core_.router, {pb::CollisionService::service_full_name(), "grpc.health.v1.Health"});
  calls_ = std::make_unique<FrameCalls>(
      builder, core_.service,
      FrameCallParts{core_.host, core_.authenticator, core_.metrics, core_.service.waiting(),
                     core_.service.parts().work, config.limits.max_message_bytes, events_});
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> watches;
  watches.push_back(std::make_unique<CallWatches>(core_.metrics, events_));
  builder.experimental().SetInterceptorCreators(std::move(watches));
  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error("gRPC cannot start the server");
  calls_->start();
}

void Daemon::abandoned(const std::string& peer) {
  if (!entrance_.connections().abandoned(peer)) return;
  core_.metrics.count(CounterId::kResetFloods);
  log_event(spdlog::level::warn, "connection ended: its client keeps opening and resetting streams", {{"peer", peer}});
}

Daemon::~Daemon() {
  if (!server_) return;
  begin_stop(0);
  stop();
}

void Daemon::reload(const Config& config) {
  core_.authenticator.reload(config);
  core_.host.set_limits(config.limits);
  entrance_.set_limit(config);
}

void Daemon::wait_responsive() const {
  (void)lifecycle_.status();
  (void)gauges();
}

void Daemon::begin_stop(double grace_seconds) {
  entrance_.end_probe();
  health_.set_serving(false);
  lifecycle_.drain();
  core_.host.announce_stop(grace_seconds);
  calls_->announce_stop();
  if (local_) local_->announce_stop();
}

bool Daemon::wait_idle(std::chrono::steady_clock::time_point deadline) const {
  constexpr auto kPoll = std::chrono::milliseconds(5);
  for (; core_.service.in_work() > 0 || calls_->open() > 0 || (local_ && local_->connections() > 0);
       std::this_thread::sleep_for(kPoll))
    if (std::chrono::steady_clock::now() >= deadline) return false;
  return true;
}

void Daemon::stop() {
  core_.host.end_streams();
  const bool idle = wait_idle(std::chrono::steady_clock::now() + kLastAnswers);
  entrance_.close();
  // Shutdown also waits for idle connections, which some clients never close, hence no longer than for the last
  // answers.
  server_->Shutdown(std::chrono::system_clock::now() + (idle ? kLastAnswers : std::chrono::milliseconds(0)));
  calls_->stop();
  if (local_) local_->stop();
  server_->Wait();
  core_.metrics.set_gauges({});
  core_.host.scenes().clear();
  server_.reset();
}

}  // namespace collided::server
