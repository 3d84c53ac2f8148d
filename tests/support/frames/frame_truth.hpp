#pragma once
// The exact truth of two real frames: `truth/vf.csv` (vertex,triangle,collides,toi) and `truth/ee.csv`
// (a0,a1,b0,b1,collides,toi: the edges by their vertices). A pair that is not listed does not collide.

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/frames/real_frames.hpp"
#include "tests/support/labelled/labelled.hpp"

namespace collided::test {

struct TruthRow {
  std::vector<uint32_t> ids;  ///< vertex and triangle, or the vertices of both edges
  bool hit = false;
  std::string toi;  ///< decimal, exact to its last digit; empty for a miss
};
std::vector<TruthRow> read_truth(const RealFrames& frames, QueryKind kind);

/// All rows of the truth as queries, in their order: vertex-triangle first.
std::vector<LabelledQuery> read_frame_queries(const RealFrames& frames);

}  // namespace collided::test
