#pragma once
// What toml11 3 (Debian 12) and 4 (Debian 13) name differently.
#include <string>
#include <toml.hpp>

namespace collided::server {

#if TOML11_VERSION_MAJOR >= 4
using TomlError = toml::syntax_error;
inline const std::string& text_in(const toml::value& value) { return value.as_string(); }
inline size_t line_of(const toml::value& value) { return value.location().first_line_number(); }
/// The line of the first mistake; 1 where there is none.
inline size_t line_of(const TomlError& error) {
  for (const auto& mistake : error.errors())
    for (const auto& [location, text] : mistake.locations()) return location.first_line_number();
  return 1;
}
#else
using TomlError = toml::exception;
inline const std::string& text_in(const toml::value& value) { return value.as_string().str; }
inline size_t line_of(const toml::value& value) { return value.location().line(); }
inline size_t line_of(const TomlError& error) { return error.location().line(); }
#endif

}  // namespace collided::server
