#pragma once
// The truth about one step: all its contacts.

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace collided::cli {

/// Identifies a pair: vertex, triangle, 0, 0; or the vertices of two edges, smaller vertex and smaller edge first.
using PairKey = std::array<uint32_t, 4>;
PairKey edge_pair(std::array<uint32_t, 2> a, std::array<uint32_t, 2> b);

struct TrueContact {
  PairKey pair;
  double toi;
  double last_toi;  ///< the latest that the truth's precision allows; a reported time above it is late
};

/// The contacts, sorted by pair; no other pair touches.
struct Truth {
  std::vector<TrueContact> vertex_triangle, edge_edge;
  uint64_t bounded = 0;  ///< contacts whose time of impact is known only to within kBoundedTime
};

/// Reads vf.csv (vertex,triangle,collides,toi) and ee.csv (a0,a1,b0,b1,collides,toi) in a folder, with times of impact
/// as decimals that are exact up to their last digit. Throws std::runtime_error naming file, line and what is wrong.
Truth read_truth(const std::filesystem::path& folder);

}  // namespace collided::cli
