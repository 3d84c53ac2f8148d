// Connections to one address with its credentials.

#include "client/cpp/transport/grpc/channel.hpp"

#include <grpcpp/create_channel.h>
#include <grpcpp/support/channel_arguments.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <fstream>
#include <iterator>

#include "client/cpp/error.hpp"
#include "client/cpp/transport/grpc/address.hpp"
#include "client/cpp/transport/grpc/deadline.hpp"
#include "collided/v1/collision_service.grpc.pb.h"
#include "proto/constants.hpp"

namespace collided::client {

namespace {

constexpr int kKeepaliveMs = 10'000, kKeepaliveTimeoutMs = 5'000;

std::string read_file(const char* option, const std::string& name) {
  std::ifstream in(name, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in || text.empty())
    throw Error(grpc::INVALID_ARGUMENT, std::string(option) + " is '" + name + "', which cannot be read", option);
  return text;
}

/// The same of a file that must have a block of PEM whose title ends with `what`. gRPC would not say what is wrong with
/// another one, but only fail to connect.
std::string read_pem(const char* option, const std::string& name, const std::string& what) {
  std::string text = read_file(option, name);
  if (text.find(what + "-----") == std::string::npos)
    throw Error(grpc::INVALID_ARGUMENT, std::string(option) + " is '" + name + "', which holds no " + what + " (PEM)",
                option);
  return text;
}

/// Why a channel did not connect, if gRPC says so; else empty. gRPC reports it only to calls, so this makes one.
std::string reason_of(const std::shared_ptr<grpc::Channel>& channel) {
  grpc::ClientContext context;
  context.set_deadline(deadline_in(std::chrono::seconds(1)));
  v1::GetServerInfoResponse response;
  const grpc::Status status = v1::CollisionService::NewStub(channel)->GetServerInfo(&context, {}, &response);
  if (status.error_code() != grpc::UNAVAILABLE) return "";
  const std::string text = status.error_message(), before = "last error: ";
  const size_t last = text.find(before);
  if (last == std::string::npos) return ": " + text;
  return text.substr(text.find(": ", last + before.size()));  // drops the name of the status code
}

/// Whether gRPC metadata can carry it: visible ASCII.
bool is_visible(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
}

void check_token(const ConnectOptions& options, const std::string& address) {
  if (!is_visible(options.token))
    throw Error(grpc::INVALID_ARGUMENT, "token has a character that is not visible ASCII", "token");
  if (options.token.empty() || !options.tls_ca.empty() || options.allow_insecure_token || is_local_address(address))
    return;
  throw Error(grpc::INVALID_ARGUMENT,
              "token is not sent to '" + address + "' in plain text; use TLS (tls_ca) or allow_insecure_token",
              "token");
}

void check_options(const ConnectOptions& options) {
  if (options.tls_certificate.empty() != options.tls_key.empty())
    throw Error(grpc::INVALID_ARGUMENT, "tls_certificate and tls_key go together; only one is set", "tls_key");
  if (options.tls_ca.empty() && !(options.tls_certificate + options.tls_server_name).empty())
    throw Error(grpc::INVALID_ARGUMENT, "tls_ca is empty; tls_certificate and tls_server_name need it", "tls_ca");
}

grpc::ChannelArguments call_arguments(uint64_t max_answer_bytes) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(static_cast<int>(std::min<uint64_t>(max_answer_bytes, INT_MAX)));
  return arguments;
}

std::shared_ptr<grpc::ChannelCredentials> credentials_of(const ConnectOptions& options) {
  if (options.tls_ca.empty()) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions tls;
  tls.pem_root_certs = read_pem("tls_ca", options.tls_ca, "CERTIFICATE");
  if (!options.tls_key.empty()) {
    tls.pem_cert_chain = read_pem("tls_certificate", options.tls_certificate, "CERTIFICATE");
    tls.pem_private_key = read_pem("tls_key", options.tls_key, "PRIVATE KEY");
  }
  return grpc::SslCredentials(tls);
}

}  // namespace

ChannelFactory::ChannelFactory(std::string address, ConnectOptions options)
    : address_(std::move(address)), options_(std::move(options)) {
  check_address(address_);
  check_options(options_);
  check_token(options_, address_);
  credentials_ = credentials_of(options_);
}

ChannelFactory::ChannelFactory(std::shared_ptr<const InProcess> daemon, ConnectOptions options)
    : in_process_(std::move(daemon)), options_(std::move(options)) {
  check_options(options_);
  if (!options_.token.empty() || !options_.tls_ca.empty())
    throw Error(grpc::INVALID_ARGUMENT, "token and tls_ca are for a daemon elsewhere; this one is in the process",
                options_.token.empty() ? "tls_ca" : "token");
}

ChannelFactory ChannelFactory::with(ConnectOptions options) const {
  if (in_process_) return {in_process_, std::move(options)};
  return {address_, std::move(options)};
}

std::shared_ptr<grpc::Channel> ChannelFactory::make(uint64_t max_answer_bytes) const {
  grpc::ChannelArguments arguments = call_arguments(max_answer_bytes);
  // Otherwise gRPC shares connections within a process, and failed attempts of one delay the others.
  arguments.SetInt("grpc.use_local_subchannel_pool", 1);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);  // no limit, to watch idle streams as well
  if (is_local_address(address_)) arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  if (!options_.tls_server_name.empty()) arguments.SetSslTargetNameOverride(options_.tls_server_name);
  return grpc::CreateCustomChannel(address_, credentials_, arguments);
}

std::shared_ptr<grpc::Channel> ChannelFactory::connect(uint64_t max_answer_bytes) const {
  if (in_process_) return in_process_->channel(call_arguments(max_answer_bytes));
  auto channel = make(max_answer_bytes);
  if (!channel->WaitForConnected(deadline_in(options_.patience)))
    throw Error(grpc::UNAVAILABLE, "no daemon answers at " + address_ + " within " +
                                       std::to_string(options_.patience.count()) + " ms (patience)" +
                                       reason_of(channel));
  return channel;
}

std::unique_ptr<grpc::ClientContext> ChannelFactory::context(const std::string& scene_id) const {
  auto context = std::make_unique<grpc::ClientContext>();
  // Not as call credentials, which gRPC refuses on plain-text channels, Unix sockets included.
  if (!options_.token.empty()) context->AddMetadata("authorization", "Bearer " + options_.token);
  if (!scene_id.empty() && is_visible(scene_id)) context->AddMetadata("scene-id", scene_id);
  return context;
}

std::unique_ptr<grpc::ClientContext> ChannelFactory::context_within(const std::string& scene_id,
                                                                    std::chrono::milliseconds time) const {
  auto context = this->context(scene_id);
  context->set_deadline(deadline_in(std::min(time, options_.deadline)));
  return context;
}

std::unique_ptr<grpc::ClientContext> ChannelFactory::call_context(const std::string& scene_id,
                                                                  std::chrono::milliseconds more) const {
  auto context = this->context(scene_id);
  const auto max = std::chrono::milliseconds::max();
  context->set_deadline(deadline_in(options_.deadline < max - more ? options_.deadline + more : max));
  return context;
}

}  // namespace collided::client
