#pragma once
// Queries whose answer is known: our own set (made by make_labelled.cpp) and those of the data folder.

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {

struct LabelledQuery {
  Query query;
  bool hit = false;
  double toi_lower = 0, toi_upper = 1;  ///< of a hit: the first time of contact is within, bounds included
  std::string family;                   ///< our own: as in made_families.cpp; else the set's name
};

/// Whether the judge's answer is the label's: the verdict, and intervals of the first time that share a point.
bool agrees(const ExactImpact& impact, const LabelledQuery& label);

/// Our own set, or any file of its form: see tests/support/data/README.md. Throws std::runtime_error if it cannot be read.
std::vector<LabelledQuery> read_labelled_set(const std::filesystem::path& file);

/// tests/support/data/labelled_queries.csv of this source tree.
std::filesystem::path labelled_set();

/// The hand-made queries of the data folder, of one set (a folder in `ccd-queries`); their times are not known.
std::vector<LabelledQuery> read_query_set(const std::filesystem::path& data, const std::string& set);
std::vector<std::string> query_sets(const std::filesystem::path& data);  ///< ascending

}  // namespace collided::test
