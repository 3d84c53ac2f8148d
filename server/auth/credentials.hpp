#pragma once
// TLS for the gRPC server.

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>
#include <string>

#include "server/config/config.hpp"

namespace collided::server {

/// Plain text without a certificate. With `tls.client_ca`, clients must show a certificate of it. Renewed files are
/// taken up without a restart. Throws ConfigError if a file cannot be used.
std::shared_ptr<grpc::ServerCredentials> make_credentials(const Tls& tls);

/// The common name of the verified certificate of a client, else its first alternative name; empty without one.
std::string certificate_name(const grpc::AuthContext& context);

}  // namespace collided::server
