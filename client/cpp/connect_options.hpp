#pragma once
// How a client reaches its daemon.

#include <chrono>
#include <string>

namespace collided::client {

/// Files are in PEM format. TLS is used if tls_ca is set, else the connection is plain text.
struct ConnectOptions {
  std::chrono::milliseconds patience = std::chrono::seconds(5);   ///< time to connect
  std::chrono::milliseconds deadline = std::chrono::seconds(60);  ///< for one call, and a stream's first answer
  std::string token = "";                                         ///< bearer token; empty: none is sent
  std::string tls_ca = "";  ///< file with the certificates to trust, such as /etc/ssl/certs/ca-certificates.crt
  std::string tls_certificate = "";   ///< file of the client's own certificate (mTLS); needs tls_key
  std::string tls_key = "";           ///< file of its private key
  std::string tls_server_name = "";   ///< name in the daemon's certificate if it is not the address's
  bool allow_insecure_token = false;  ///< send the token in plain text even to another host
};

}  // namespace collided::client
