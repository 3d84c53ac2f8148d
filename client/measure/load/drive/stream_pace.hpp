#pragma once
// When one stream sends its frames, and what became of them. It reads no clock and knows no network.

#include <chrono>
#include <deque>
#include <limits>
#include <optional>

#include "client/measure/load/pace/schedule.hpp"
#include "client/measure/load/tally/tally.hpp"
#include "collided/v1/collision_service.pb.h"

namespace collided::cli::load {

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;
constexpr Time kNever = Time::max();

inline double ms_between(Time from, Time to) { return std::chrono::duration<double, std::milli>(to - from).count(); }

inline Clock::duration seconds_of(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// Part of a run, in which all streams send in the same way.
struct Phase {
  Time start = {};
  const RateProfile* profile = nullptr;  ///< of each stream, outlives the phase; null: closed loop
  Arrivals arrivals = Arrivals::kFixed;
  uint64_t seed = 1;
  uint64_t max_frames = std::numeric_limits<uint64_t>::max();                    ///< of each stream, in a closed loop
  uint32_t first_stream = 0, end_stream = std::numeric_limits<uint32_t>::max();  ///< the others send nothing
};

/// Where a frame that ends is counted.
struct Books {
  Tally& tally;
  Second& second;
};

class StreamPace {
 public:
  void open(uint32_t window) { window_ = window; }
  void begin(const Phase& phase, StreamPlace place);
  /// When the next frame should be sent; kNever after the last one.
  Time due() const { return due_; }
  /// Whether the window has room, and the connection has taken the frame before.
  bool can_send() const { return in_flight_.size() < window_ && !is_writing_; }
  bool is_writing() const { return is_writing_; }
  bool is_idle() const { return in_flight_.empty() && due_ == kNever; }

  /// The next frame is sent; returns its id.
  uint64_t send(Time now, Books books);
  void written(Time now);
  /// Takes the answer, `done`, `error` or `skipped`, to the frame that is next in order.
  void take(const v1::StreamFramesResponse& answer, Time now, Books books);
  /// Sends nothing more; frames that are due stay unsent and uncounted (closed loop).
  void stop() { due_ = kNever; }
  /// Counts frames without an answer, and those that are overdue, with the time that they have waited. What is answered
  /// later is not counted again.
  void give_up(Time now, Tally& tally);

 private:
  struct InFlight {
    Time intended, sent;
    bool is_counted = false;
  };

  bool is_open_loop() const { return schedule_.has_value(); }
  void plan_next();
  void count_done(const InFlight& frame, const v1::FrameDone& done, Time now, Books books);
  void count_refused(const v1::FrameError& error, Time now, Books books);

  std::optional<Schedule> schedule_;
  Time start_, due_ = kNever;
  Time able_since_;  ///< since when the window or the connection has had room
  uint64_t frames_left_ = 0, last_id_ = 0;
  uint32_t window_ = 0;
  bool is_writing_ = true;  ///< at first the opening
  std::deque<InFlight> in_flight_;
};

}  // namespace collided::cli::load
