#pragma once
// The file of bearer tokens.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "server/auth/client.hpp"

namespace collided::server {

using Digest = std::array<unsigned char, 32>;

/// SHA-256.
Digest digest_of(std::string_view token);

struct Token {
  Digest digest{};
  Client client;
};

/// From TOML: [[tokens]] with name (1 to 64 printable characters), either token (16 to 512 printable characters) or
/// sha256 (64 hexadecimal digits), and limits of the client where they differ from `defaults`. Throws ConfigError that
/// names file, line and key, and never contains a token.
std::vector<Token> read_tokens(const std::string& path, const ClientLimits& defaults);

}  // namespace collided::server
