// What serves scenes and calls, whichever way they come in.
#include "server/core.hpp"

#include <algorithm>
#include <climits>

namespace collided::server {
namespace {

// The slack lets our own refusal, which names the option, come first for messages not far above the limit. Compressed
// messages could expand a thousandfold within gRPC, which does not limit that.
void set_message_limits(grpc::ServerBuilder& builder, uint64_t max_message_bytes) {
  constexpr uint64_t kSlack = uint64_t{1} << 20;
  builder.SetMaxReceiveMessageSize(static_cast<int>(std::min<uint64_t>(max_message_bytes + kSlack, INT_MAX)));
  for (const auto algorithm : {GRPC_COMPRESS_DEFLATE, GRPC_COMPRESS_GZIP})
    builder.SetCompressionAlgorithmSupportStatus(algorithm, false);
}

}  // namespace

Core::Core(const Config& config, Lifecycle& lifecycle)
    : authenticator(config),
      observer(metrics, lifecycle),
      host(config, observer),
      service(config, host, authenticator),
      max_message_bytes(config.limits.max_message_bytes) {}

void Core::add_to(grpc::ServerBuilder& builder) {
  set_message_limits(builder, max_message_bytes);
  service.add_to(router);
  builder.RegisterService(&service);
  builder.RegisterCallbackGenericService(&router);
}

}  // namespace collided::server
