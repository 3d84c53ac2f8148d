#pragma once
// TLS for the gRPC server.

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>
#include <string>

#include "server/auth/certificate_watch.hpp"

namespace collided::server {

/// Each handshake uses the watch's files of that time; where it asks clients, they must show a certificate. Hold them
/// until the server is gone; the watch outlives them.
std::shared_ptr<grpc::ServerCredentials> make_credentials(const CertificateWatch& watch);

/// Of the verified certificate of a client: its common name, else "san:" and its first alternative name; empty without
/// one. No two certificates whose names differ have the same: a common name that begins with "san:" or "cn:" gets "cn:"
/// before it.
std::string certificate_name(const grpc::AuthContext& context);

}  // namespace collided::server
