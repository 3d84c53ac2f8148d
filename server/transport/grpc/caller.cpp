// Who makes a call.
#include "server/transport/grpc/caller.hpp"

#include <spdlog/fmt/fmt.h>

#include <string_view>
#include <utility>

#include "server/auth/credentials.hpp"

namespace collided::server {
namespace {

using Metadata = std::multimap<grpc::string_ref, grpc::string_ref>;

std::string_view header(const Metadata& metadata, const char* name) {
  const auto found = metadata.find(name);
  return found == metadata.end() ? std::string_view() : std::string_view(found->second.data(), found->second.size());
}

// gRPC has one name for all Unix sockets, and does not tell whose they are.
Origin origin_of(const grpc::ServerContextBase& context) {
  return {source_of(context.peer()), fmt::format("{}", connection_of(*context.auth_context()))};
}

}  // namespace

CallIds ids_of(const Metadata& metadata) {
  return parse_ids(header(metadata, "x-request-id"), header(metadata, "traceparent"));
}

Caller identify(const grpc::ServerContextBase& context, const Authenticator& authenticator) {
  const Metadata& metadata = context.client_metadata();
  const auto name = certificate_name(*context.auth_context());
  Client client = authenticator.identify(header(metadata, "authorization"), name, origin_of(context));
  authenticator.admit(context.peer(), *client);
  return {std::move(client), ids_of(metadata)};
}

}  // namespace collided::server
