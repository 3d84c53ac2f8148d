#pragma once
// What the gRPC server knows of its connections: TLS, and which call came over which.

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/server_credentials.h>

#include <functional>
#include <memory>
#include <string>

#include "server/auth/certificate_watch.hpp"

namespace collided::server {

/// Asked by gRPC's threads about each call as it arrives, before it waits to be accepted; false refuses the call
/// (RESOURCE_EXHAUSTED). `connection`: as connection_of() tells it.
using AdmitCall = std::function<bool(const void* connection)>;

/// Each handshake uses the watch's current files; with a CA for clients, they must present a certificate. The
/// credentials must outlive the server, and the watch must outlive them.
std::shared_ptr<grpc::ServerCredentials> make_credentials(const CertificateWatch& watch, AdmitCall admit);
/// Tells whose connections the credentials get, as Origin::party has it. Called for the first call of each connection.
using Party = std::function<std::string()>;
/// Without TLS. The credentials must outlive the server. `party`: may be empty.
std::shared_ptr<grpc::ServerCredentials> make_plain_credentials(AdmitCall admit, Party party = {});

/// Returns what the credentials' Party told of this connection; empty if there is none.
std::string party_of(const grpc::AuthContext& context);

/// The same for all calls of a connection; unique while one of them lives.
const void* connection_of(const grpc::AuthContext& context);

/// Name of a client's verified certificate: its common name, else "san:" and its first alternative name; empty without
/// a certificate. To keep names distinct, a common name that begins with "san:" or "cn:" is prefixed with "cn:".
std::string certificate_name(const grpc::AuthContext& context);

}  // namespace collided::server
