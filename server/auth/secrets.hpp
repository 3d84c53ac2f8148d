#pragma once
// Ids and secrets that nobody can guess.

#include <string>
#include <string_view>

namespace collided::server {

/// Returns 128 bits of the operating system's generator as 32 hexadecimal digits. Throws std::system_error.
std::string random_id();

/// Compares in a time that depends on the sizes alone. These are no secret.
bool is_equal_secret(std::string_view a, std::string_view b);

}  // namespace collided::server
