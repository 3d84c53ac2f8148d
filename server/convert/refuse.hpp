#pragma once
// How the conversions refuse a value: the message begins with the path of its field.

#include <spdlog/fmt/fmt.h>

#include <string>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {

[[noreturn]] inline void throw_invalid(const std::string& field, const std::string& rest) {
  throw InvalidInput(field, field + " " + rest);
}

[[noreturn]] inline void throw_not_served(const std::string& field, const std::string& value) {
  throw Unimplemented(field, fmt::format("{} is {}, which is not served", field, value));
}

[[noreturn]] inline void throw_unknown(const std::string& field, int value) {
  throw_invalid(field, fmt::format("is {}, which is no value of its enum that can be used", value));
}

}  // namespace collided::server
