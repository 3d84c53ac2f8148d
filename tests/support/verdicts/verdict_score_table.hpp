#pragma once
// The results of each level on each family, as a file.

#include <iosfwd>
#include <string>
#include <vector>

#include "tests/support/verdicts/verdict_score.hpp"

namespace collided::test {

/// Scores by family, scalar type and level; both kinds of queries together.
class ScoreTable {
 public:
  void add(const std::string& family, Scalar scalar, Accuracy accuracy, const Score& score);
  /// `commit`: of the sources, for the head; today's date goes there too.
  void write_json(std::ostream& out, const std::string& device, const std::string& commit) const;

 private:
  struct Row {
    std::string family;
    Scalar scalar;
    Accuracy accuracy;
    Score score;
  };
  std::vector<Row> rows_;  ///< in order of addition
};

}  // namespace collided::test
