#pragma once
// All streams: opened together, driven through the phases of a run, and ended together.

#include <functional>
#include <memory>
#include <vector>

#include "client/measure/load/daemon/target.hpp"
#include "client/measure/load/drive/motion.hpp"
#include "client/measure/load/drive/phase_result.hpp"

namespace collided::cli::load {

/// Which frames are sent when, and for how long.
struct PhasePlan {
  const RateProfile* profile = nullptr;  ///< null: closed loop
  Arrivals arrivals = Arrivals::kFixed;
  uint64_t seed = 1;
  double seconds = 0;       ///< of a closed loop; an open one has those of its profile
  uint64_t max_frames = 0;  ///< of each stream in a closed loop; 0: no limit
  double drain_seconds = 5;
};

class Fleet {
 public:
  using OnSecond = std::function<void(const SeriesPoint&)>;

  /// Creates the scenes and opens a stream to each. Throws Error, std::runtime_error, Interrupted.
  Fleet(Target& target, const LoadSettings& settings, const Motion& motion);
  ~Fleet();

  const v1::Scene& scene() const;  ///< one of them; all are alike
  uint64_t bytes_per_frame() const;
  size_t connections() const;
  size_t threads() const;
  /// Ends early if it is interrupted, or if all streams have ended.
  PhaseResult run(const PhasePlan& plan, const OnSecond& on_second = {});
  /// Waits until every stream has all answers to what it has sent. False if that takes too long.
  bool settle();
  /// Ends the streams and deletes the scenes.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace collided::cli::load
