#pragma once
// Runs levels, deltas and position formats over one step and judges them.

#include "client/app/input/step_input.hpp"
#include "client/app/options/values.hpp"
#include "client/measure/tradeoff/result.hpp"

namespace collided::cli {

struct TradeoffSettings {
  ServerOptions server;
  DetectionOptions detection;  ///< its accuracy is not used
  std::vector<std::string> levels{"fast", "guarded", "certified", "exact"};
  std::vector<double> deltas{0};  ///< of every level but fast
  std::vector<std::string> formats{"f32", "f64"};
  int repeats = 5;
  std::string truth;  ///< folder; empty: the level exact
};

/// Throws UsageError naming a position format that none of the levels is for.
void check_runs(const TradeoffSettings& settings);

/// Fills in everything but date and commit. If it throws, `result` has the position formats that were completed.
void measure(const TradeoffSettings& settings, const StepInput& step, Tradeoff& result);

}  // namespace collided::cli
