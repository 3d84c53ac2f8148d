// Reads and checks the TLS files.
#include "server/auth/tls_files.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <memory>

#include "server/auth/secret_file.hpp"
#include "server/config/file/text_file.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMaxFileBytes = 1 << 20;

using Context = std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)>;
using Source = std::unique_ptr<BIO, decltype(&BIO_free)>;
using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;
using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

Source source_of(const std::string& text) {
  return {BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), BIO_free};
}

// The reason of OpenSSL's last error; empties its queue.
std::string reason() {
  const auto code = ERR_peek_last_error();
  ERR_clear_error();
  const char* text = ERR_reason_error_string(code);
  return text ? text : "unknown error";
}

// Without it OpenSSL would ask for the password at the terminal.
int no_password(char*, int, int, void*) { return 0; }

// At the end no further block begins; any other error means that the file is truncated.
bool is_end() { return ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE; }

Certificate next_certificate(BIO* source) {
  return {PEM_read_bio_X509_AUX(source, nullptr, no_password, nullptr), X509_free};
}

[[noreturn]] void refuse(const char* option, const std::string& path, const std::string& why) {
  throw ConfigError(std::string(option) + " " + path + ": " + why);
}

std::string read_file(const char* option, const std::string& path) try {
  return path.empty() ? "" : read_text_file(path, kMaxFileBytes);
} catch (const ConfigError& error) {
  throw ConfigError(std::string(option) + " " + error.what());
}

void check_dates(const X509& certificate, const std::string& path) {
  if (X509_cmp_current_time(X509_get0_notAfter(&certificate)) < 0) refuse("--tls-certificate", path, "has expired");
  if (X509_cmp_current_time(X509_get0_notBefore(&certificate)) > 0)
    refuse("--tls-certificate", path, "is not valid yet");
}

void use_certificate(SSL_CTX* context, const std::string& text, const std::string& path) {
  constexpr auto kOption = "--tls-certificate";
  const Source source = source_of(text);
  const Certificate own = next_certificate(source.get());
  if (!own || SSL_CTX_use_certificate(context, own.get()) != 1) refuse(kOption, path, reason());
  check_dates(*own, path);
  while (const Certificate next = next_certificate(source.get()))
    if (SSL_CTX_add1_chain_cert(context, next.get()) != 1) refuse(kOption, path, reason());
  if (!is_end()) refuse(kOption, path, reason());
  ERR_clear_error();
}

void use_key(SSL_CTX* context, const std::string& text, const std::string& path) {
  const Source source = source_of(text);
  const Key key(PEM_read_bio_PrivateKey(source.get(), nullptr, no_password, nullptr), EVP_PKEY_free);
  if (!key || SSL_CTX_use_PrivateKey(context, key.get()) != 1 || SSL_CTX_check_private_key(context) != 1)
    refuse("--tls-key", path, reason());
}

void check_client_ca(const std::string& text, const std::string& path) {
  constexpr auto kOption = "--tls-client-ca";
  const Source source = source_of(text);
  if (!next_certificate(source.get())) refuse(kOption, path, reason());
  while (next_certificate(source.get())) continue;
  if (!is_end()) refuse(kOption, path, reason());
  ERR_clear_error();
}

}  // namespace

TlsFiles read_tls_files(const Tls& tls) {
  return {read_file("--tls-certificate", tls.certificate), read_file("--tls-key", tls.key),
          read_file("--tls-client-ca", tls.client_ca)};
}

void check_tls_files(const Tls& tls, const TlsFiles& files) {
  const Context context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
  if (!context) throw ConfigError("OpenSSL: " + reason());
  ERR_clear_error();
  use_certificate(context.get(), files.certificate, tls.certificate);
  use_key(context.get(), files.key, tls.key);
  if (!tls.client_ca.empty()) check_client_ca(files.client_ca, tls.client_ca);
}

TlsFiles sound_tls_files(const Tls& tls) {
  if (!tls.enabled()) return {};
  TlsFiles files = read_tls_files(tls);
  check_tls_files(tls, files);
  warn_if_others_can_read(tls.key);
  return files;
}

}  // namespace collided::server
