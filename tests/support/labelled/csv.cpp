#include "tests/support/labelled/csv.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace collided::test {

std::vector<CsvRow> read_csv(const std::filesystem::path& file, bool has_header) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file.string());
  std::string line, cell;
  if (has_header) std::getline(in, line);
  std::vector<CsvRow> rows;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(cell);
  }
  return rows;
}

double real_number(const std::string& cell) { return std::strtod(cell.c_str(), nullptr); }

}  // namespace collided::test
