#include "tests/support/verdicts/verdict_score_table.hpp"

#include <algorithm>
#include <ctime>
#include <ostream>

#include "tests/support/families/query_families.hpp"

namespace collided::test {
namespace {

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[16];
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

}  // namespace

void ScoreTable::add(const std::string& family, Scalar scalar, Accuracy accuracy, const Score& score) {
  const auto same = [&](const Row& r) { return r.family == family && r.scalar == scalar && r.accuracy == accuracy; };
  const auto row = std::find_if(rows_.begin(), rows_.end(), same);
  if (row != rows_.end())
    row->score += score;
  else
    rows_.push_back({family, scalar, accuracy, score});
}

void ScoreTable::write_json(std::ostream& out, const std::string& device, const std::string& commit) const {
  out << "{\n  \"date\": \"" << today() << "\", \"commit\": \"" << commit << "\", \"device\": \"" << device
      << "\",\n  \"rows\": [\n";
  for (const Row& row : rows_) {
    const Score& s = row.score;
    out << "    {\"family\": \"" << row.family << "\", \"scalar\": \"" << name_of(row.scalar) << "\", \"level\": \""
        << name_of(row.accuracy) << "\", \"queries\": " << s.queries << ", \"hits\": " << s.hits
        << ", \"missed\": " << s.missed << ", \"late\": " << s.late << ", \"false\": " << s.false_hits
        << ", \"capped\": " << s.capped << ", \"certified\": " << s.certified << ", \"median_gap\": " << s.median_gap()
        << ", \"worst_gap\": " << s.worst_gap() << ", \"worst_delay\": " << s.worst_delay() << "}"
        << (&row == &rows_.back() ? "\n" : ",\n");
  }
  out << "  ]\n}\n";
}

}  // namespace collided::test
