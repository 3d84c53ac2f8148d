#include "tests/support/labelled/labelled.hpp"

#include "tests/support/labelled/csv.hpp"

namespace collided::test {
namespace {

LabelledQuery labelled(const CsvRow& row) {
  constexpr size_t kCoordinates = 6;  // the first column of them
  LabelledQuery q;
  q.family = row.at(0);
  q.query.kind = row.at(1) == "vt" ? QueryKind::kVertexTriangle : QueryKind::kEdgeEdge;
  q.hit = row.at(2) == "1";
  q.toi_lower = real_number(row.at(3));
  q.toi_upper = real_number(row.at(4));
  for (size_t i = 0; i < 24; ++i) q.query.p[i / 3][i % 3] = real_number(row.at(kCoordinates + i));
  return q;
}

}  // namespace

bool agrees(const ExactImpact& impact, const LabelledQuery& label) {
  if (impact.hit != label.hit) return false;
  return !label.hit || (impact.lower <= label.toi_upper && impact.upper >= label.toi_lower);
}

std::vector<LabelledQuery> read_labelled_set(const std::filesystem::path& file) {
  std::vector<LabelledQuery> queries;
  for (const CsvRow& row : read_csv(file, true)) queries.push_back(labelled(row));
  return queries;
}

std::filesystem::path labelled_set() { return COLLIDED_LABELLED_SET; }

}  // namespace collided::test
