#pragma once
// The truth about one step: the contacts that there are.

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace collided::cli {

/// Names a pair: vertex, triangle, 0, 0; or the vertices of two edges, lower vertex and lower edge first.
using PairKey = std::array<uint32_t, 4>;
PairKey edge_pair(std::array<uint32_t, 2> a, std::array<uint32_t, 2> b);

struct TrueContact {
  PairKey pair;
  double toi;
  double last_toi;  ///< what the truth's own last digit still allows: a later time of impact is late
};

/// Contacts that there are, by pair; no other pair meets.
struct Truth {
  std::vector<TrueContact> vertex_triangle, edge_edge;
  uint64_t bounded = 0;  ///< contacts whose time of impact is known to kBoundedTime only
};

/// Reads vf.csv (vertex,triangle,collides,toi) and ee.csv (a0,a1,b0,b1,collides,toi) of a folder, times of impact as
/// exact decimals. Throws std::runtime_error naming file, line and what is wrong.
Truth read_truth(const std::filesystem::path& folder);

}  // namespace collided::cli
