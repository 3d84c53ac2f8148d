#include "tests/support/frames/frame_truth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tests/support/case_queries.hpp"
#include "tests/support/labelled/csv.hpp"

namespace collided::test {
namespace {

// Bounds of a decimal number that is exact to its last digit, whether rounded or truncated.
std::array<double, 2> bounds_of(const std::string& decimal) {
  const size_t point = decimal.find('.'), exponent = decimal.find_first_of("eE");
  const size_t end = std::min(decimal.size(), exponent);
  const int digits = point < end ? static_cast<int>(end - point - 1) : 0;
  const int power = exponent < decimal.size() ? std::stoi(decimal.substr(exponent + 1)) : 0;
  const double value = real_number(decimal), unit = std::pow(10.0, power - digits);
  const double infinity = std::numeric_limits<double>::infinity();
  return {std::nextafter(value - unit, -infinity), std::nextafter(value + unit, infinity)};
}

Query query_of(const CaseQueries& queries, QueryKind kind, const std::vector<uint32_t>& ids) {
  if (kind == QueryKind::kVertexTriangle) return queries.of_pair(kind, key_of(ids[0], ids[1]));
  return queries.of_vertices(kind, {ids[0], ids[1], ids[2], ids[3]});
}

}  // namespace

std::vector<TruthRow> read_truth(const RealFrames& frames, QueryKind kind) {
  const bool vertex_triangle = kind == QueryKind::kVertexTriangle;
  const size_t ids = vertex_triangle ? 2 : 4;
  std::vector<TruthRow> rows;
  for (const CsvRow& row : read_csv(folder_of(frames) / "truth" / (vertex_triangle ? "vf.csv" : "ee.csv"), true)) {
    rows.push_back({{}, row.at(ids) == "1", row.size() > ids + 1 ? row[ids + 1] : ""});
    for (size_t i = 0; i < ids; ++i) rows.back().ids.push_back(static_cast<uint32_t>(std::stoul(row[i])));
  }
  return rows;
}

std::vector<LabelledQuery> read_frame_queries(const RealFrames& frames) {
  const CaseQueries features(load(frames));
  std::vector<LabelledQuery> queries;
  for (const QueryKind kind : {QueryKind::kVertexTriangle, QueryKind::kEdgeEdge})
    for (const TruthRow& row : read_truth(frames, kind)) {
      queries.push_back({query_of(features, kind, row.ids), row.hit, 0, 1, frames.name});
      if (!row.hit) continue;
      const std::array<double, 2> toi = bounds_of(row.toi);
      queries.back().toi_lower = toi[0];
      queries.back().toi_upper = toi[1];
    }
  return queries;
}

}  // namespace collided::test
