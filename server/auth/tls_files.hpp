#pragma once
// Whether the files for TLS can be used.

#include "server/config/config.hpp"

namespace collided::server {

/// Throws ConfigError that names the file if it cannot be read, is not PEM, the key is of another certificate, or the
/// certificate is not valid now. Logs a warning if others can read the key.
void check_tls_files(const Tls& tls);

}  // namespace collided::server
