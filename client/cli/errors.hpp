#pragma once
// Bad usage, found after the options were parsed: exit code 2. Every other exception is an error in the work: 1.

#include <stdexcept>

namespace collided::cli {

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace collided::cli
