// TLS for the gRPC server.
#include "server/auth/credentials.hpp"

#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include "server/auth/tls_files.hpp"

namespace collided::server {
namespace {

constexpr unsigned kRefreshSeconds = 1;  // how often renewed files are looked for

}  // namespace

std::shared_ptr<grpc::ServerCredentials> make_credentials(const Tls& tls) {
  if (!tls.enabled()) return grpc::InsecureServerCredentials();
  check_tls_files(tls);
  using grpc::experimental::FileWatcherCertificateProvider;
  grpc::experimental::TlsServerCredentialsOptions options(
      std::make_shared<FileWatcherCertificateProvider>(tls.key, tls.certificate, tls.client_ca, kRefreshSeconds));
  options.watch_identity_key_cert_pairs();
  if (!tls.client_ca.empty()) {
    options.watch_root_certs();
    options.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  }
  return grpc::experimental::TlsServerCredentials(options);
}

std::string certificate_name(const grpc::AuthContext& context) {
  if (!context.IsPeerAuthenticated()) return {};
  for (const auto* property : {"x509_common_name", "x509_subject_alternative_name"}) {
    const auto values = context.FindPropertyValues(property);
    if (!values.empty() && !values.front().empty()) return {values.front().data(), values.front().size()};
  }
  return {};
}

}  // namespace collided::server
