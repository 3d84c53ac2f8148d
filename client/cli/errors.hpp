#pragma once
// Exit codes: bad usage, found after the options were parsed, 2; an interrupt, 128 + the signal's number. Every other
// exception is an error in the work: 1.

#include <stdexcept>
#include <string>

namespace collided::cli {

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Interrupted : std::runtime_error {
  explicit Interrupted(int number)
      : std::runtime_error("interrupted by signal " + std::to_string(number)), signal_number(number) {}
  int signal_number;
};

/// Standard output does not take what is written there; nobody reads it any more if `error` is EPIPE.
struct OutputClosed : std::runtime_error {
  explicit OutputClosed(int error) : std::runtime_error("standard output cannot be written"), error_number(error) {}
  int error_number;
};

}  // namespace collided::cli
