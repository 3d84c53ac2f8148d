#pragma once
// TLS for the gRPC server.

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>
#include <string>

#include "server/auth/certificate_watch.hpp"

namespace collided::server {

/// Each handshake uses the watch's current files; with a CA for clients, they must present a certificate. The
/// credentials must outlive the server, and the watch must outlive them.
std::shared_ptr<grpc::ServerCredentials> make_credentials(const CertificateWatch& watch);

/// Name of a client's verified certificate: its common name, else "san:" and its first alternative name; empty without
/// a certificate. To keep names distinct, a common name that begins with "san:" or "cn:" is prefixed with "cn:".
std::string certificate_name(const grpc::AuthContext& context);

}  // namespace collided::server
