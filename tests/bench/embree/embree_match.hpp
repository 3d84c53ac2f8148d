#pragma once
// The engine's broad phase against Embree's, on one step of a case.

#include <string>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

struct Contender {
  std::string name;
  bool is_embree = false;
  std::vector<double> ms = {};        ///< of each round
  std::vector<double> build_ms = {};  ///< of each round, part of `ms`: Embree alone
};

struct Match {
  uint64_t triangles = 0;
  std::vector<Contender> contenders;
  uint64_t embree_pairs = 0;        ///< triangles whose boxes overlap, not both of static meshes
  uint64_t embree_pairs_apart = 0;  ///< those of them that share no vertex
  uint64_t engine_pairs = 0;        ///< FrameCounts::pairs
  bool lists_pairs = false;         ///< whether the engine lists the triangle pairs of a step
  uint64_t listed_pairs = 0;
  uint64_t candidates_vt = 0, candidates_ee = 0;

  /// The engine may leave pairs that share a vertex out of its list, no others.
  bool agrees() const {
    return engine_pairs == embree_pairs &&
           (!lists_pairs || listed_pairs == embree_pairs || listed_pairs == embree_pairs_apart);
  }
};

/// Rounds of all contenders in turn, after two warm-up rounds. README.md says what is timed.
Match run_match(const Case& c, int rounds, int threads);

}  // namespace collided::test
