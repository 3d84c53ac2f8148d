// Reads a truth of real arithmetic from CSV files.

#include "client/measure/tradeoff/truth.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string>

namespace collided::cli {

namespace {

struct Row {
  std::vector<uint32_t> ids;
  bool collides = false;
  std::string toi;
};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',')
      cells.emplace_back();
    else if (c != '\r')
      cells.back() += c;
  }
  return cells;
}

template <class T>
bool parse(const std::string& text, T& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

/// One unit in the last digit of a decimal such as 7.49e-06.
double last_digit(const std::string& decimal) {
  const size_t e = std::min(decimal.find_first_of("eE"), decimal.size());
  const size_t point = decimal.find('.');
  const int places = point < e ? static_cast<int>(e - point - 1) : 0;
  int exponent = 0;
  if (e < decimal.size()) parse(decimal.substr(decimal[e + 1] == '+' ? e + 2 : e + 1), exponent);
  return std::pow(10.0, exponent - places);
}

Row parse_row(const std::string& line, size_t ids) {
  const std::vector<std::string> cells = split(line);
  if (cells.size() != ids + 2)
    throw std::runtime_error("has " + std::to_string(cells.size()) + " cells; it needs " + std::to_string(ids + 2));
  Row row{std::vector<uint32_t>(ids), cells[ids] == "1", cells[ids + 1]};
  for (size_t i = 0; i < ids; ++i)
    if (!parse(cells[i], row.ids[i])) throw std::runtime_error("'" + cells[i] + "' is no id");
  if (!row.collides && cells[ids] != "0") throw std::runtime_error("collides is '" + cells[ids] + "', not 0 or 1");
  return row;
}

TrueContact contact_of(const Row& row, const PairKey& pair) {
  double toi = 0;
  if (!parse(row.toi, toi) || !(toi >= 0 && toi <= 1))
    throw std::runtime_error("toi is '" + row.toi + "'; it must be in [0, 1]");
  return {pair, toi, std::nextafter(toi + last_digit(row.toi), 2)};
}

std::vector<TrueContact> read_kind(const std::filesystem::path& file, const std::string& header, size_t ids,
                                   PairKey (*key)(const std::vector<uint32_t>&)) {
  std::ifstream in(file);
  std::string line;
  if (!in || !std::getline(in, line)) throw std::runtime_error(file.string() + ": cannot be read");
  if (line.substr(0, line.find('\r')) != header)
    throw std::runtime_error(file.string() + ":1: the first line is not '" + header + "'");
  std::vector<TrueContact> out;
  for (size_t number = 2; std::getline(in, line); ++number) {
    try {
      if (const Row row = parse_row(line, ids); row.collides) out.push_back(contact_of(row, key(row.ids)));
    } catch (const std::runtime_error& e) {
      throw std::runtime_error(file.string() + ":" + std::to_string(number) + ": " + e.what());
    }
  }
  std::sort(out.begin(), out.end(), [](const TrueContact& a, const TrueContact& b) { return a.pair < b.pair; });
  return out;
}

PairKey vertex_triangle_of(const std::vector<uint32_t>& ids) { return {ids[0], ids[1], 0, 0}; }
PairKey edge_edge_of(const std::vector<uint32_t>& ids) { return edge_pair({ids[0], ids[1]}, {ids[2], ids[3]}); }

}  // namespace

PairKey edge_pair(std::array<uint32_t, 2> a, std::array<uint32_t, 2> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  if (b < a) std::swap(a, b);
  return {a[0], a[1], b[0], b[1]};
}

Truth read_truth(const std::filesystem::path& folder) {
  return {read_kind(folder / "vf.csv", "vertex,triangle,collides,toi", 2, vertex_triangle_of),
          read_kind(folder / "ee.csv", "a0,a1,b0,b1,collides,toi", 4, edge_edge_of), 0};
}

}  // namespace collided::cli
