#pragma once
// Checks of options that are numbers.

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdint>
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

/// Refuses what CLI11 takes for a number of 64 bits all the same: negative ones, which wrap around, and larger ones.
inline CLI::Validator whole_number() {
  const auto check = [](const std::string& word) {
    uint64_t n = 0;
    const char* const end = word.data() + word.size();
    const auto [rest, error] = std::from_chars(word.data(), end, n);
    return error == std::errc() && rest == end
               ? std::string()
               : "'" + word + "' is not a whole number from 0 to " + std::to_string(UINT64_MAX);
  };
  return CLI::Validator(check, "");
}

}  // namespace collided::cli
