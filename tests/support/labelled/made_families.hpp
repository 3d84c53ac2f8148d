#pragma once
// The families of our own labelled set whose answers are known by construction.

#include <functional>
#include <vector>

#include "tests/support/labelled/made_queries.hpp"

namespace collided::test {

struct MadeFamily {
  const char* name;
  std::function<Made(Dice&, QueryKind)> make;
  bool edges_only = false;
};

const std::vector<MadeFamily>& made_families();

}  // namespace collided::test
