#pragma once
// Clients' text in the daemon's messages.

#include <cstddef>
#include <string>

namespace collided::server {

/// At most `bytes` of a UTF-8 text, not cut within a character: a gRPC message must be UTF-8.
inline std::string shorten(const std::string& text, size_t bytes) {
  if (text.size() <= bytes) return text;
  while (bytes > 0 && (static_cast<unsigned char>(text[bytes]) & 0xC0) == 0x80) --bytes;
  return text.substr(0, bytes);
}

}  // namespace collided::server
