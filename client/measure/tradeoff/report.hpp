#pragma once
// Results of 'collidectl tradeoff' for people.

#include <string>

#include "client/measure/tradeoff/result.hpp"

namespace collided::cli {

/// A section of Markdown: how it was measured, then a table of the answers against the truth and one of their cost.
std::string tradeoff_markdown(const Tradeoff& result);

/// A line for each run: contacts, missed, false and late ones, and the time of the narrow phase.
std::string tradeoff_text(const Tradeoff& result);

/// A delta as people write it, such as "1e-6"; the daemon's own choice is "auto".
std::string delta_text(double delta);

}  // namespace collided::cli
