// Who makes a call.
#include "server/service/caller.hpp"

#include <grpc/grpc_security_constants.h>

#include <string_view>

namespace collided::server {
namespace {

std::string_view header(const grpc::ServerContextBase& context, const char* name) {
  const auto& metadata = context.client_metadata();
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

Caller identify(const grpc::ServerContextBase& context, const Authenticator& authenticator) {
  return {authenticator.identify(header(context, "authorization"), certificate_name(context)),
          parse_ids(header(context, "x-request-id"), header(context, "traceparent"))};
}

}  // namespace collided::server
