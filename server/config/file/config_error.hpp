#pragma once
// Why a configuration cannot be.

#include <stdexcept>

namespace collided::server {

/// An invalid option, or an unusable file that an option names.
class ConfigError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace collided::server
