#pragma once
// Refusals of values: the message begins with the path of the field.

#include <google/protobuf/generated_enum_reflection.h>
#include <spdlog/fmt/fmt.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {

[[noreturn]] inline void throw_invalid(const std::string& field, const std::string& what) {
  throw InvalidInput(field, field + " " + what);
}

/// "A", "A or B", "A, B or C".
inline std::string list_choices(const std::vector<std::string>& names) {
  std::string list;
  for (size_t i = 0; i < names.size(); ++i) list += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return list;
}

/// Refuses a value of an enum, with the names of the usable ones.
template <class Enum>
[[noreturn]] void throw_unknown(const std::string& field, Enum value, const std::vector<Enum>& usable) {
  const auto* type = google::protobuf::GetEnumDescriptor<Enum>();
  const auto name_of = [&](Enum each) {
    const auto* known = type->FindValueByNumber(static_cast<int>(each));
    return known ? known->name() : std::string();
  };
  std::vector<std::string> names;
  for (const Enum each : usable) names.push_back(name_of(each));
  const std::string name = name_of(value);
  throw_invalid(field, fmt::format("is {}, but must be {}",
                                   name.empty() ? std::to_string(static_cast<int>(value)) : name, list_choices(names)));
}

}  // namespace collided::server
