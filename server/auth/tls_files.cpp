// Whether the files for TLS can be used.
#include "server/auth/tls_files.hpp"

#include <openssl/err.h>
#include <openssl/ssl.h>

#include <memory>
#include <string>

#include "server/auth/secret_file.hpp"

namespace collided::server {
namespace {

using Context = std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)>;

// Of OpenSSL's last error; empties its queue.
std::string reason() {
  const auto code = ERR_peek_last_error();
  ERR_clear_error();
  const char* text = ERR_reason_error_string(code);
  return text ? text : "unknown error";
}

// Without it, OpenSSL would ask the terminal for the password.
int no_password(char*, int, int, void*) { return 0; }

void check_dates(const SSL_CTX& context, const std::string& path) {
  const X509* certificate = SSL_CTX_get0_certificate(&context);
  if (X509_cmp_current_time(X509_get0_notAfter(certificate)) < 0)
    throw ConfigError("--tls-certificate " + path + ": has expired");
  if (X509_cmp_current_time(X509_get0_notBefore(certificate)) > 0)
    throw ConfigError("--tls-certificate " + path + ": is not valid yet");
}

}  // namespace

void check_tls_files(const Tls& tls) {
  if (!tls.enabled()) return;
  const Context context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
  if (!context) throw ConfigError("OpenSSL: " + reason());
  SSL_CTX_set_default_passwd_cb(context.get(), no_password);
  if (SSL_CTX_use_certificate_chain_file(context.get(), tls.certificate.c_str()) != 1)
    throw ConfigError("--tls-certificate " + tls.certificate + ": " + reason());
  if (SSL_CTX_use_PrivateKey_file(context.get(), tls.key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      SSL_CTX_check_private_key(context.get()) != 1)
    throw ConfigError("--tls-key " + tls.key + ": " + reason());
  if (!tls.client_ca.empty() && SSL_CTX_load_verify_file(context.get(), tls.client_ca.c_str()) != 1)
    throw ConfigError("--tls-client-ca " + tls.client_ca + ": " + reason());
  check_dates(*context, tls.certificate);
  warn_if_others_can_read(tls.key);
}

}  // namespace collided::server
