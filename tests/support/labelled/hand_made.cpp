// Queries made by hand by others: eight rows each, coordinates as fractions.

#include <algorithm>
#include <stdexcept>

#include "tests/support/labelled/csv.hpp"
#include "tests/support/labelled/labelled.hpp"

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

}  // namespace collided::test
