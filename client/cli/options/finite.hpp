#pragma once
// Checks of options that are real numbers.

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

namespace collided::cli {

/// Refuses NaN, which passes every range check of CLI11, and infinities.
inline CLI::Validator finite() {
  const auto check = [](std::string& word) {
    double x = 0;
    using CLI::detail::lexical_cast;
    return lexical_cast(word, x) && std::isfinite(x) ? std::string() : "'" + word + "' is not a finite number";
  };
  return CLI::Validator(check, "");
}

/// Refuses negative numbers; CLI11's own check would print the largest double in full.
inline CLI::Validator at_least_zero() {
  const auto check = [](std::string& word) {
    double x = 0;
    using CLI::detail::lexical_cast;
    return lexical_cast(word, x) && x >= 0 ? std::string() : "'" + word + "' is not a number of at least 0";
  };
  return CLI::Validator(check, "");
}

}  // namespace collided::cli
