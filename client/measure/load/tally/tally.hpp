#pragma once
// What was measured: counts of frames, and their times.

#include <map>
#include <string>
#include <vector>

#include "client/measure/load/tally/histogram.hpp"

namespace collided::cli::load {

/// Refused frames, or ended streams, with one gRPC code.
struct Refusals {
  uint64_t count = 0;
  std::string first;  ///< message of the first one
};
using RefusalsByCode = std::map<std::string, Refusals>;

void add(RefusalsByCode& sum, const std::string& code, const std::string& message, uint64_t count = 1);

/// Every frame that is due ends up in exactly one of `answered`, `skipped`, `refused`, `unanswered` and `unsent`.
struct Tally {
  uint64_t sent = 0, answered = 0, skipped = 0;
  uint64_t unanswered = 0;  ///< sent, but without an answer by the end
  uint64_t unsent = 0;      ///< due, but never sent: the window was full until the end
  uint64_t late = 0;        ///< answered after it had been counted as unanswered
  RefusalsByCode refused;

  /// From when the frame should have been sent to its complete answer. Frames that are unanswered or unsent count with
  /// the time that they had waited by the end, so that a daemon that no longer answers is seen here, too.
  Histogram latency;
  Histogram service;  ///< from when it was sent; answered frames only
  Histogram delay;    ///< from when it could be sent, being due and within the window, until it was: the tester's own
  /// The daemon's times, from each answer's FrameMetrics.
  Histogram total, queue, decode, engine, encode;
  uint64_t contacts = 0, bytes_in = 0, bytes_out = 0;

  uint64_t refused_count() const;
  uint64_t due() const { return answered + skipped + refused_count() + unanswered + unsent; }
  Tally& operator+=(const Tally& other);
};

/// One second of a run.
struct Second {
  uint64_t sent = 0, answered = 0, skipped = 0, refused = 0;
  Histogram latency;  ///< of the frames that were answered in it

  Second& operator+=(const Second& other);
};

/// What is kept of a second.
struct SeriesPoint {
  double begin = 0, end = 0;  ///< seconds since the start; the last one is shorter
  uint64_t sent = 0, answered = 0, skipped = 0, refused = 0;
  double p50 = 0, p99 = 0, max = 0;  ///< 0 if none was answered
};

SeriesPoint point_of(double begin, double end, const Second& second);

}  // namespace collided::cli::load
