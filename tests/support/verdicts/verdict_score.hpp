#pragma once
// The engine's verdicts on queries, compared with the judge's.

#include <span>
#include <string>
#include <vector>

#include "tests/support/verdicts/query_batch.hpp"

namespace collided::test {

/// Queries and their truth.
struct Judged {
  Mode mode = Mode::kCcd;
  double thickness = 0;
  std::vector<Query> queries;
  std::vector<ExactImpact> truth;  ///< DCD: whether the points of t = 1 are within the thickness; no time
};

/// Asks the judge about each query, on all cores. The queries must be rounded already.
Judged judge(std::vector<Query> queries, Mode mode, double thickness);

/// A verdict that breaks a promise.
struct Offence {
  size_t query;
  std::string what;
};

struct Score {
  uint64_t queries = 0;
  uint64_t hits = 0;    ///< by the judge
  uint64_t missed = 0;  ///< hits that were not reported
  uint64_t late = 0;    ///< hits reported at a time after the true one
  uint64_t false_hits = 0;
  uint64_t capped = 0;             ///< reported with kFlagCapped
  uint64_t certified = 0;          ///< reported with kFlagCertified
  uint64_t wrongly_certified = 0;  ///< false hits with kFlagCertified
  uint64_t wrong_initial = 0;      ///< certified hits with kFlagInitial that are not in contact at t = 0; EXACT: and
                                   ///< those without it that are
  uint64_t malformed = 0;          ///< times outside [0, 1], distances that are negative or NaN
  std::vector<double> gaps;        ///< of the hits: by how much their time is early; late ones are below 0

  double worst_gap() const;
  double median_gap() const;
  double worst_delay() const;  ///< maximum by which a time is late
  Score& operator+=(const Score& other);
};

/// `offences`, if given, gets misses, late times, wrong flags and malformed verdicts, and false hits at EXACT.
Score score(const Judged& judged, std::span<const Verdict> verdicts, Accuracy accuracy,
            std::vector<Offence>* offences = nullptr);

/// The median of the queries' extents, for choosing tolerances.
double typical_extent(std::span<const Query> queries);

/// Verdict and truth, for messages.
std::string text_of(const Verdict& verdict);
std::string text_of(const ExactImpact& truth);

/// Of the levels that have verdicts.
std::string name_of(Accuracy accuracy);

}  // namespace collided::test
