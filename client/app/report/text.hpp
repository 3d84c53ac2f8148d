#pragma once
// Reports for people: aligned lines, numbers with units, measured values in three or four digits.

#include <string>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// An object as aligned lines "name  value", nested objects indented. The name gives the unit: "step_ms" becomes
/// "step  12.3 ms". null means that something was not counted.
std::string report_text(const Json& object, size_t indent = 0);

/// A name that somebody else chose, which must not steer the terminal: what is not printable ASCII is shown as "?".
std::string shown_name(std::string name);

}  // namespace collided::cli
