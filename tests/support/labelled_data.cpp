#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/support/csv.hpp"
#include "tests/support/labelled.hpp"

namespace collided::test {
namespace {

// Every coordinate of the sets is exactly a double, so that nothing is lost.
double exact_double(const std::string& numerator, const std::string& denominator) {
  const mpq_class value = mpq_class(mpz_class(numerator)) / mpq_class(mpz_class(denominator));
  const double rounded = value.get_d();
  if (mpq_class(rounded) != value) throw std::runtime_error(numerator + "/" + denominator + " is not a double");
  return rounded;
}

void append_queries(std::vector<LabelledQuery>& queries, const std::filesystem::path& file, QueryKind kind,
                    const std::string& family) {
  const std::vector<CsvRow> rows = read_csv(file, false);
  if (rows.size() % 8 != 0) throw std::runtime_error(file.string() + ": not eight rows a query");
  for (size_t i = 0; i < rows.size(); ++i) {
    if (i % 8 == 0) queries.push_back({{kind, {}}, rows[i].at(6) == "1", 0, 1, family});
    for (size_t k = 0; k < 3; ++k)
      queries.back().query.p[i % 8][k] = exact_double(rows[i].at(2 * k), rows[i].at(2 * k + 1));
  }
}

// Bounds of a decimal number that is exact to its last digit, whether it was rounded or cut there.
std::array<double, 2> bounds_of(const std::string& decimal) {
  const size_t point = decimal.find('.'), exponent = decimal.find_first_of("eE");
  const size_t end = std::min(decimal.size(), exponent);
  const int digits = point < end ? static_cast<int>(end - point - 1) : 0;
  const int power = exponent < decimal.size() ? std::stoi(decimal.substr(exponent + 1)) : 0;
  const double value = real_number(decimal), unit = std::pow(10.0, power - digits);
  const double infinity = std::numeric_limits<double>::infinity();
  return {std::nextafter(value - unit, -infinity), std::nextafter(value + unit, infinity)};
}

}  // namespace

std::vector<std::string> query_sets(const std::filesystem::path& data) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(data / "ccd-queries"))
    if (entry.is_directory()) names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

std::vector<LabelledQuery> read_query_set(const std::filesystem::path& data, const std::string& set) {
  std::vector<LabelledQuery> queries;
  for (const auto& [folder, kind] :
       {std::pair{"vertex-face", QueryKind::kVertexTriangle}, std::pair{"edge-edge", QueryKind::kEdgeEdge}})
    for (const auto& entry : std::filesystem::directory_iterator(data / "ccd-queries" / set / folder))
      append_queries(queries, entry.path(), kind, set);
  return queries;
}

std::vector<TruthRow> read_truth(const std::filesystem::path& data, const RealFrames& frames, QueryKind kind) {
  const bool vertex_triangle = kind == QueryKind::kVertexTriangle;
  const size_t ids = vertex_triangle ? 2 : 4;
  std::vector<TruthRow> rows;
  for (const CsvRow& row : read_csv(data / frames.folder / "truth" / (vertex_triangle ? "vf.csv" : "ee.csv"), true)) {
    rows.push_back({{}, row.at(ids) == "1", row.size() > ids + 1 ? row[ids + 1] : ""});
    for (size_t i = 0; i < ids; ++i) rows.back().ids.push_back(static_cast<uint32_t>(std::stoul(row[i])));
  }
  return rows;
}

std::vector<LabelledQuery> read_frame_queries(const std::filesystem::path& data, const RealFrames& frames) {
  const Case c = load(data, frames);
  std::vector<LabelledQuery> queries;
  for (const QueryKind kind : {QueryKind::kVertexTriangle, QueryKind::kEdgeEdge})
    for (const TruthRow& row : read_truth(data, frames, kind)) {
      std::vector<uint32_t> points = row.ids;
      if (kind == QueryKind::kVertexTriangle) {
        const auto& corners = c.meshes[0].triangles.at(row.ids[1]);
        points = {row.ids[0], corners[0], corners[1], corners[2]};
      }
      queries.push_back({{kind, {}}, row.hit, 0, 1, frames.name});
      for (size_t i = 0; i < 4; ++i) {
        queries.back().query.p[i] = c.start[0].at(points[i]);
        queries.back().query.p[i + 4] = c.end[0].at(points[i]);
      }
      if (!row.hit) continue;
      const std::array<double, 2> toi = bounds_of(row.toi);
      queries.back().toi_lower = toi[0];
      queries.back().toi_upper = toi[1];
    }
  return queries;
}

}  // namespace collided::test
