#pragma once
// Families of queries on which collision detection tends to fail. Query i of a family is the same on every machine.

#include <functional>
#include <string>
#include <vector>

#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {

class Random;

struct QueryFamily {
  std::string name;
  /// Coordinates fit the scalar type's range, but are not rounded to it yet.
  std::function<Query(QueryKind, Scalar, Random&)> make;
  bool f64_only = false;
};

/// The nine families that are run in large numbers; tests/fuzz/README.md.
const std::vector<QueryFamily>& fuzz_families();

/// One family for each known failure of the usual methods; tests/extremes/README.md.
const std::vector<QueryFamily>& extreme_families();

/// Queries that cost exact decisions the most, with a thickness of 1/2 and without; for tests of these alone.
const std::vector<QueryFamily>& costly_families();

/// Of the fuzz families; throws std::invalid_argument.
const QueryFamily& fuzz_family(const std::string& name);

/// Identifies the queries of one kind of a family, so that each can be regenerated.
struct QuerySource {
  const QueryFamily* family;
  QueryKind kind;
  Scalar scalar;
  uint64_t seed;
};

/// Query `index` of the source, rounded to its scalar type.
Query query_of(const QuerySource& source, uint64_t index);
std::vector<Query> queries_of(const QuerySource& source, uint64_t count);

Query rounded(Query query, Scalar scalar);

/// The largest distance along an axis between any two of the eight points.
double extent_of(const Query& query);

/// "VT" or "EE" and 24 coordinates as hexadecimal floats, and back; throws std::invalid_argument.
std::string text_of(const Query& query);
Query query_from(const std::string& text);

std::string name_of(QueryKind kind);
std::string name_of(Scalar scalar);

}  // namespace collided::test
