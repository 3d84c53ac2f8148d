#pragma once
// Tables of comma-separated cells, without quotes.

#include <filesystem>
#include <string>
#include <vector>

namespace collided::test {

using CsvRow = std::vector<std::string>;

/// Throws std::runtime_error if the file cannot be read.
std::vector<CsvRow> read_csv(const std::filesystem::path& file, bool has_header);

/// Decimal or hex float; subnormal numbers too.
double real_number(const std::string& cell);

}  // namespace collided::test
