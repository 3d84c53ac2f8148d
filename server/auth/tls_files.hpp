#pragma once
// Reads and checks the TLS files.

#include <string>

#include "server/config/config.hpp"

namespace collided::server {

/// Their contents; empty for files that are not configured.
struct TlsFiles {
  std::string certificate, key, client_ca;

  bool operator==(const TlsFiles&) const = default;
};

/// Throws ConfigError, naming the file that cannot be read.
TlsFiles read_tls_files(const Tls& tls);

/// Throws ConfigError, naming the file, if it is not PEM or truncated, if the key belongs to another certificate, or if
/// the certificate is not valid now.
void check_tls_files(const Tls& tls, const TlsFiles& files);

/// Reads and checks them. Logs a warning if others can read the key.
TlsFiles sound_tls_files(const Tls& tls);

}  // namespace collided::server
