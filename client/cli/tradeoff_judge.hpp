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
  uint64_t bounded = 0;  ///< contacts whose time of impact is known to kBoundedTime only
};

/// What EXACT's time of impact of a contact that it was certain of without exact arithmetic may be early by.
inline constexpr double kBoundedTime = 1e-9;
/// A delta that makes EXACT decide in exact arithmetic all that it is not certain of from t = 0 on.
inline constexpr double kWideDelta = 1e30;

/// Reads vf.csv (vertex,triangle,collides,toi) and ee.csv (a0,a1,b0,b1,collides,toi) of a folder, times of impact as
/// exact decimals. Throws std::runtime_error naming file, line and what is wrong.
Truth read_truth(const std::filesystem::path& folder);

/// The answers of the level EXACT with the daemon's own delta and with kWideDelta as truth: the first has a close lower
/// bound of every time of impact, the second exact ones (within 2^-60) wherever it gives any but 0. Throws
/// std::runtime_error if they contradict each other.
Truth exact_truth(const client::FrameOutput& close, const client::FrameOutput& wide);

Score judge(const Truth& truth, const client::FrameOutput& output);

}  // namespace collided::cli
