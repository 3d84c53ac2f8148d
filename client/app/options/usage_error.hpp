#pragma once
// Bad usage that shows only after the options are parsed.

#include <stdexcept>

namespace collided::cli {

/// Ends collidectl with exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace collided::cli
