#pragma once
// The engine's narrow phase on single queries, without a broad phase in front of it.

#include <span>

#include "gpu/detector.hpp"
#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {

struct BatchSettings {
  Backend backend = Backend::kCpu;
  Mode mode = Mode::kCcd;
  Scalar scalar = Scalar::kF64;
  Accuracy accuracy = Accuracy::kCertified;  ///< from kFast on
  double delta = 0;
  double thickness = 0;
};

/// The engine's verdict on one query.
struct Verdict {
  bool hit = false;
  double toi = 1;
  double distance = 0;
  uint8_t flags = 0;  ///< ContactFlags
};

/// Verdicts of queries of one kind, in their order. Coordinates are rounded to the scalar type first, so a judge must
/// get rounded queries, too. DCD looks at the points of t = 1.
std::vector<Verdict> run_queries(std::span<const Query> queries, const BatchSettings& settings);

}  // namespace collided::test
