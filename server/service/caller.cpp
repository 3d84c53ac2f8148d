// Who makes a call.
#include "server/service/caller.hpp"

#include <grpc/grpc_security_constants.h>

#include <string_view>

namespace collided::server {
namespace {

using Metadata = std::multimap<grpc::string_ref, grpc::string_ref>;

std::string_view header(const Metadata& metadata, const char* name) {
  const auto found = metadata.find(name);
  return found == metadata.end() ? std::string_view() : std::string_view(found->second.data(), found->second.size());
}

std::string certificate_name(const grpc::ServerContextBase& context) {
  const auto auth = context.auth_context();
  if (!auth || !auth->IsPeerAuthenticated()) return {};
  const auto names = auth->FindPropertyValues(GRPC_X509_CN_PROPERTY_NAME);
  return names.empty() ? std::string() : std::string(names[0].data(), names[0].size());
}

}  // namespace

CallIds ids_of(const Metadata& metadata) {
  return parse_ids(header(metadata, "x-request-id"), header(metadata, "traceparent"));
}

Caller identify(const grpc::ServerContextBase& context, const Authenticator& authenticator) {
  const Metadata& metadata = context.client_metadata();
  return {authenticator.identify(header(metadata, "authorization"), certificate_name(context)), ids_of(metadata)};
}

}  // namespace collided::server
