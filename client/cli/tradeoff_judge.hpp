#pragma once
// The truth about one step, and reported contacts judged by it.

#include <array>
#include <filesystem>
#include <vector>

#include "client/cli/tradeoff_result.hpp"
#include "client/cpp/frame_stream.hpp"

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
};

/// Reads vf.csv (vertex,triangle,collides,toi) and ee.csv (a0,a1,b0,b1,collides,toi) of a folder, times of impact as
/// exact decimals. Throws std::runtime_error naming file, line and what is wrong.
Truth read_truth(const std::filesystem::path& folder);

/// The answer of the level EXACT as truth.
Truth exact_truth(const client::FrameOutput& output);

Score judge(const Truth& truth, const client::FrameOutput& output);

}  // namespace collided::cli
