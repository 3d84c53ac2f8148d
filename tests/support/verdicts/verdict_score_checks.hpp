#pragma once
// The levels' promises as GoogleTest checks, for the backend that the executable tests.

#include "tests/gpu/backend.hpp"
#include "tests/support/verdicts/verdict_score_question.hpp"
#include "tests/support/verdicts/verdict_score_table.hpp"

namespace collided::test {

/// Checks the promises of every level on the question's queries, which are judged once; `table`, if given, gets
/// the scores of the default delta.
void expect_promises(const Question& question, ScoreTable* table = nullptr);

/// The score of one level with the default delta.
Score score_of(const Question& question, Accuracy accuracy);

/// Writes the table, at the end of all tests, to the file that the environment variable `variable` names, if any; its
/// head names the commit that COLLIDED_COMMIT names.
class ScoreFile : public ::testing::Environment {
 public:
  explicit ScoreFile(std::string variable) : variable_(std::move(variable)) {}
  void TearDown() override;
  ScoreTable table;

 private:
  std::string variable_;
};

}  // namespace collided::test
