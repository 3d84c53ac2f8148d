#pragma once
// Reports for people: aligned lines, numbers with their units, three or four digits of what was measured.

#include <string>

#include "client/cli/report/json.hpp"

namespace collided::cli {

/// An object as aligned lines "name  value"; nested objects are indented. The name tells the unit: "step_ms" becomes
/// "step  12.3 ms". What is null was not counted.
std::string report_text(const Json& object, size_t indent = 0);

}  // namespace collided::cli
