#pragma once
// Results of 'collidectl tradeoff': runs of accuracy levels, deltas and position formats, judged and timed.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace collided::cli {

/// Contacts of one kind against the truth.
struct KindScore {
  uint64_t reported = 0;
  uint64_t right = 0;
  uint64_t missed = 0;
  uint64_t wrong = 0;  ///< reported, but no contact ("false")
  uint64_t late = 0;   ///< right, but with a time of impact after the true one
  bool operator==(const KindScore&) const = default;
};

/// True time of impact minus the reported one, over all right contacts, as a fraction of the step; < 0 is late.
struct Gap {
  double median = 0, p99 = 0, worst = 0;
  bool operator==(const Gap&) const = default;
};

struct Score {
  KindScore vertex_triangle, edge_edge;
  std::optional<Gap> gap;  ///< none if no contact is right
  double latest = 0;       ///< how late the latest contact is
  bool operator==(const Score&) const = default;
};

inline KindScore sum(const Score& score) {
  const KindScore &a = score.vertex_triangle, &b = score.edge_edge;
  return {a.reported + b.reported, a.right + b.right, a.missed + b.missed, a.wrong + b.wrong, a.late + b.late};
}

/// Medians over the repeats, in milliseconds.
struct Times {
  double narrow = 0;  ///< narrow phase and exact decisions, without the filter, which is part of finding pairs
  double stages = 0;  ///< all stages
  double total = 0;   ///< from the frame's arrival to the end of its work
  std::map<std::string, double> stage;
};

struct Work {
  uint64_t survivors_vertex_triangle = 0, survivors_edge_edge = 0, exact_decisions = 0;
  uint64_t certified = 0, near = 0, capped = 0;  ///< contacts with that flag
};

struct Run {
  std::string format;                ///< f32, f64 or q16
  std::string level;                 ///< fast, guarded, certified or exact
  std::optional<double> delta = {};  ///< none for levels that take none; 0: the daemon chooses
  Score score = {};
  Times times = {};
  Work work = {};
  uint64_t bytes = 0;  ///< of the positions of a frame, at both ends of the step
};

/// What the runs of one position format were judged by.
struct TruthUsed {
  std::string format;
  std::string source;  ///< "exact" (the level EXACT on the same positions) or the folder that was given
  uint64_t vertex_triangle = 0, edge_edge = 0;
  uint64_t bounded = 0;  ///< contacts whose time of impact is not exact, but at most 1e-9 early
};

struct Tradeoff {
  std::string name, input;  ///< what was run: its name, and all that is needed to run it again
  std::string date, commit, version, backend, device;
  uint64_t vertices = 0, edges = 0, triangles = 0;
  double thickness = 0;
  int repeats = 0;
  std::vector<TruthUsed> truths;
  std::vector<Run> runs;
};

}  // namespace collided::cli
