#pragma once
// Ends a command whose work is done with an exit code of its own.

#include <stdexcept>

namespace collided::cli {

/// The work is done and its report is printed, but the result is not what was hoped for. Exit code 3.
struct DoneBut : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace collided::cli
