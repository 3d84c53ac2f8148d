#pragma once
// The one definition of each option: its flag, its COLLIDED_* variable, its key in the TOML file, its range.

#include <CLI/CLI.hpp>
#include <charconv>
#include <concepts>
#include <string>
#include <type_traits>

#include "server/config/config.hpp"

namespace collided::server {

inline constexpr auto kProgram = "collided";
inline constexpr auto kSummary = "collided: collision detection as a service";

/// Options that are not part of the configuration.
struct Switches {
  std::string version = "";  ///< what --version prints
  std::string config_file = "";
  bool check = false;
  bool is_private = false;
};

/// All options, with their defaults in `config`.
void define_options(CLI::App& app, Config& config, Switches& switches);

/// Addresses, security, engine, time and log: all but the limits.
void add_serve_options(CLI::App& app, Config& config);
void add_limit_options(CLI::App& app, Limits& limits);

/// Sets options from a TOML file, where neither a flag nor the environment has set them. Throws ConfigError that names
/// the file and the key.
void take_file(CLI::App& app, const std::string& path);

/// --max-scenes is COLLIDED_MAX_SCENES.
std::string variable_of(const std::string& flag);

/// Only decimal numbers in the range: no NaN, no octal numbers, no negative numbers that wrap around.
template <class T>
requires std::is_arithmetic_v<T> CLI::Validator number(T min, T max) {
  const auto range = "from " + CLI::detail::to_string(min) + " to " + CLI::detail::to_string(max);
  const auto check = [=](std::string& text) -> std::string {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool valid = error == std::errc() && end == text.data() + text.size() && value >= min && value <= max;
    if (!valid) return "\"" + text + "\" is not a number " + range;
    if constexpr (std::integral<T>) text = std::to_string(value);  // CLI11 would read a leading 0 as octal
    return {};
  };
  return CLI::Validator(check, range);
}

/// An option with its variable and its default in --help.
template <class T>
CLI::Option* add(CLI::App& app, const std::string& flag, T& value, const std::string& help) {
  return app.add_option(flag, value, help)->envname(variable_of(flag))->capture_default_str();
}

/// A flag by itself, or with =true or =false; a variable or key needs the value.
inline CLI::Option* add_switch(CLI::App& app, const std::string& flag, bool& value, const std::string& help) {
  const std::string initially = value ? "true" : "false";
  return app.add_flag(flag, value, help)
      ->envname(variable_of(flag))
      ->check(CLI::IsMember({"true", "false"}).description(""))
      ->type_name("true|false")
      ->default_str(initially)
      ->option_text("[=true|false] (default: " + initially + ") (Env:" + variable_of(flag) + ")");
}

/// A number with its range.
template <class T>
CLI::Option* add(CLI::App& app, const std::string& flag, T& value, T min, T max, const std::string& help) {
  return add(app, flag, value, help)->transform(number(min, max));
}

}  // namespace collided::server
