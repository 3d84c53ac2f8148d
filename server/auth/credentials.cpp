// What the gRPC server knows of its connections. gRPC's C++ API cannot swap in checked certificates at run time: its
// own file watcher ends the process if it finds an empty file; and it asks nobody about the calls of a connection
// without TLS. Hence the C API.
#include "server/auth/credentials.hpp"

#include <grpc/grpc.h>
#include <grpc/grpc_security.h>

#include <deque>
#include <mutex>
#include <string_view>
#include <utility>

namespace collided::server {
namespace {

// Every connection has this property, whose value it copies.
constexpr const char* kOwnProperty = GRPC_TRANSPORT_SECURITY_TYPE_PROPERTY_NAME;
constexpr const char* kPartyProperty = "collided_party";

const void* connection_of(const grpc_auth_context* context) {
  auto found = grpc_auth_context_find_properties_by_name(context, kOwnProperty);
  const grpc_auth_property* const property = grpc_auth_property_iterator_next(&found);
  return property ? property->value : nullptr;
}

// Credentials whose calls are admitted one by one.
class AdmittingCredentials : public grpc::ServerCredentials {
 public:
  explicit AdmittingCredentials(AdmitCall admit, Party party = {})
      : admit_(std::move(admit)), party_(std::move(party)) {}
  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  virtual grpc_server_credentials* make() = 0;

  int AddPortToServer(const std::string& address, grpc_server* server) override {
    grpc_server_credentials* const credentials = make();
    grpc_server_credentials_set_auth_metadata_processor(credentials, {ask, nullptr, this});
    const int port = grpc_server_add_http2_port(server, address.c_str(), credentials);
    grpc_server_credentials_release(credentials);
    return port;
  }

  static void ask(void* self, grpc_auth_context* context, const grpc_metadata*, size_t,
                  grpc_process_auth_metadata_done_cb done, void* call) {
    auto& credentials = *static_cast<AdmittingCredentials*>(self);
    if (credentials.party_) credentials.note_party(context);
    const bool is_admitted = credentials.admit_(connection_of(context));
    done(call, nullptr, 0, nullptr, 0, is_admitted ? GRPC_STATUS_OK : GRPC_STATUS_RESOURCE_EXHAUSTED,
         is_admitted ? nullptr : "too many calls of this connection wait to be accepted");
  }

  // All calls of a connection share its properties, which gRPC does not guard: only the first call adds one, before any
  // of them is accepted and reads it.
  void note_party(grpc_auth_context* context) {
    const std::lock_guard lock(mutex_);
    auto known = grpc_auth_context_find_properties_by_name(context, kPartyProperty);
    if (grpc_auth_property_iterator_next(&known) != nullptr) return;
    grpc_auth_context_add_cstring_property(context, kPartyProperty, party_().c_str());
  }

  AdmitCall admit_;
  Party party_;
  std::mutex mutex_;
};

class PlainCredentials final : public AdmittingCredentials {
 public:
  using AdmittingCredentials::AdmittingCredentials;

 private:
  grpc_server_credentials* make() override { return grpc_insecure_server_credentials_create(); }
};

class WatchedCredentials final : public AdmittingCredentials {
 public:
  WatchedCredentials(const CertificateWatch& watch, AdmitCall admit)
      : AdmittingCredentials(std::move(admit)), watch_(watch) {}

 private:
  /// The files that a port uses.
  struct Port {
    const CertificateWatch& watch;
    std::shared_ptr<const TlsFiles> given;
  };

  grpc_server_credentials* make() override {
    ports_.push_back({watch_, {}});
    auto* const options = grpc_ssl_server_credentials_create_options_using_config_fetcher(
        watch_.asks_clients() ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                              : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE,
        fetch, &ports_.back());
    return grpc_ssl_server_credentials_create_with_options(options);
  }

  // Before each handshake; one at a time for each port.
  static grpc_ssl_certificate_config_reload_status fetch(void* user_data, grpc_ssl_server_certificate_config** config) {
    Port& port = *static_cast<Port*>(user_data);
    const auto files = port.watch.files();
    if (files == port.given) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    // gRPC insists on CAs even if it requests no client certificates.
    const std::string& ca = files->client_ca.empty() ? files->certificate : files->client_ca;
    const grpc_ssl_pem_key_cert_pair pair{files->key.c_str(), files->certificate.c_str()};
    *config = grpc_ssl_server_certificate_config_create(ca.c_str(), &pair, 1);
    port.given = files;
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }

  const CertificateWatch& watch_;
  std::deque<Port> ports_;
};

std::string first(const grpc::AuthContext& context, const char* property) {
  const auto values = context.FindPropertyValues(property);
  return values.empty() ? std::string() : std::string(values.front().data(), values.front().size());
}

}  // namespace

std::shared_ptr<grpc::ServerCredentials> make_credentials(const CertificateWatch& watch, AdmitCall admit) {
  return std::make_shared<WatchedCredentials>(watch, std::move(admit));
}

std::shared_ptr<grpc::ServerCredentials> make_plain_credentials(AdmitCall admit, Party party) {
  return std::make_shared<PlainCredentials>(std::move(admit), std::move(party));
}

std::string party_of(const grpc::AuthContext& context) { return first(context, kPartyProperty); }

const void* connection_of(const grpc::AuthContext& context) {
  const auto values = context.FindPropertyValues(kOwnProperty);
  return values.empty() ? nullptr : values.front().data();
}

std::string certificate_name(const grpc::AuthContext& context) {
  constexpr std::string_view kCommon = "cn:", kAlternative = "san:";
  if (!context.IsPeerAuthenticated()) return {};
  const std::string common = first(context, "x509_common_name");
  if (common.starts_with(kCommon) || common.starts_with(kAlternative)) return std::string(kCommon) + common;
  if (!common.empty()) return common;
  const std::string alternative = first(context, "x509_subject_alternative_name");
  return alternative.empty() ? alternative : std::string(kAlternative) + alternative;
}

}  // namespace collided::server
