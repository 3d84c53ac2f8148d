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

}  // namespace collided::cli
