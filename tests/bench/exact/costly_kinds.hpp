#pragma once
// Inputs that cost EXACT the most beside CERTIFIED; small, so that nothing else of a frame hides it.

#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

struct CostlyKind {
  Case input;
  Mode mode = Mode::kCcd;
  double thickness = 0;
  std::vector<Scalar> scalars = {Scalar::kF32, Scalar::kF64};
};

std::vector<CostlyKind> costly_kinds();

}  // namespace collided::test
