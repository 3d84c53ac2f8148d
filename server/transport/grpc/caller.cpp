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

// gRPC itself has one name for all Unix sockets.
Origin origin_of(const grpc::ServerContextBase& context) {
  const auto auth = context.auth_context();
  const std::string party = party_of(*auth);
  return {party.empty() ? source_of(context.peer()) : party, fmt::format("{}", connection_of(*auth))};
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
