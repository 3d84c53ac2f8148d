#pragma once
// What 'collidectl tradeoff' found, as JSON, as a Markdown table, and in short.

#include <filesystem>

#include "client/cli/report/json.hpp"
#include "client/cli/report/numbers.hpp"
#include "client/measure/tradeoff/result.hpp"

namespace collided::cli {

Json tradeoff_json(const Tradeoff& result);
/// Reads back what tradeoff_json wrote to a file. Throws std::runtime_error naming the file and what is wrong.
Tradeoff read_tradeoff(const std::filesystem::path& file);

/// One section: how it was measured, the answers against the truth, what they cost.
std::string tradeoff_markdown(const Tradeoff& result);

/// Misses, false contacts and the time of each run: as JSON, and as a line each.
Json tradeoff_summary(const Tradeoff& result);
std::string tradeoff_text(const Tradeoff& result);

/// A delta as people write it, such as "1e-6"; the daemon's own choice is "auto".
std::string delta_text(double delta);

}  // namespace collided::cli
