// Ids and secrets that nobody can guess.
#include "server/auth/secrets.hpp"

#include <openssl/crypto.h>
#include <spdlog/fmt/fmt.h>
#include <sys/random.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace collided::server {

// getrandom() waits until the generator is seeded, and gives up to 256 bytes at once.
std::string random_id() {
  std::array<unsigned char, 16> bytes{};
  while (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "getrandom");
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

bool is_equal_secret(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace collided::server
