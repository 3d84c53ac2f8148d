#pragma once
// The last frames of a scene, as far as a table shows them.

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "client/app/report/json.hpp"
#include "client/cpp/watcher.hpp"

namespace collided::cli {

/// One figure of the last frames.
struct Series {
  enum class Unit { kMilliseconds, kCount, kBytes };
  std::string name;
  Unit unit = Unit::kCount;
  std::deque<double> values = {};  ///< a frame each, the oldest first, since it appeared; 0 of frames without it
};

class History {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr size_t kFrames = 120;  ///< that are kept

  /// A frame that arrived now.
  void add(const client::WatchedFrame& frame, const v1::SceneSpec& spec, Clock::time_point now);

  /// Times, stages, counts and bytes, in the order in which they appeared; counts that were never anything are left
  /// out.
  const std::vector<Series>& series() const { return series_; }
  uint64_t frames() const { return frames_; }
  uint64_t skipped() const { return skipped_; }
  uint64_t last_frame_id() const { return last_frame_id_; }
  /// None if the last frame found no times.
  std::optional<double> earliest_toi() const { return earliest_toi_; }
  bool any_contact() const { return any_contact_; }
  /// Frames a second over the last ones, also those that were not shown; 0 until there are two.
  double rate() const;

 private:
  struct Arrival {
    Clock::time_point time;
    uint64_t frames;  ///< it and those skipped before it
  };

  void begin_frame();
  void put(const std::string& name, Series::Unit unit, double value);
  void put_counts(const Json& counts);

  std::vector<Series> series_;
  std::deque<Arrival> arrivals_;
  uint64_t frames_ = 0, skipped_ = 0, last_frame_id_ = 0;
  std::optional<double> earliest_toi_;
  bool any_contact_ = false;
};

}  // namespace collided::cli
