#pragma once
// Queries whose answer is known: our own set (data/labelled_queries.csv, made by make_labelled.cpp) and those of the
// data folder.

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/data_folder.hpp"
#include "tests/support/exact_judge.hpp"

namespace collided::test {

struct LabelledQuery {
  Query query;
  bool hit = false;
  double toi_lower = 0, toi_upper = 1;  ///< of a hit: the first time of contact is within, bounds included
  std::string family;                   ///< our own: as in made_families.cpp; else the set's name
};

/// Whether the judge's answer is the label's: the verdict, and intervals of the first time that share a point.
bool agrees(const ExactImpact& impact, const LabelledQuery& label);

/// Our own set, or any file of its form: see data/README.md. Throws std::runtime_error if it cannot be read.
std::vector<LabelledQuery> read_labelled_set(const std::filesystem::path& file);

/// data/labelled_queries.csv of this source tree.
std::filesystem::path labelled_set();

/// The hand-made queries of the data folder, of one set (a folder in `ccd-queries`); their times are not known.
std::vector<LabelledQuery> read_query_set(const std::filesystem::path& data, const std::string& set);
std::vector<std::string> query_sets(const std::filesystem::path& data);  ///< ascending

/// A row of the truth of two real frames.
struct TruthRow {
  std::vector<uint32_t> ids;  ///< vertex and triangle, or the vertices of both edges
  bool hit = false;
  std::string toi;  ///< decimal, exact to its last digit; empty for a miss
};
std::vector<TruthRow> read_truth(const std::filesystem::path& data, const RealFrames& frames, QueryKind kind);

/// All rows of the truth of two real frames as queries.
std::vector<LabelledQuery> read_frame_queries(const std::filesystem::path& data, const RealFrames& frames);

}  // namespace collided::test
