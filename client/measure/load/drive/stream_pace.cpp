// When one stream sends its frames, and what became of them.

#include "client/measure/load/drive/stream_pace.hpp"

#include <algorithm>
#include <cmath>

#include "client/cpp/error.hpp"

namespace collided::cli::load {

void StreamPace::begin(const Phase& phase, StreamPlace place) {
  schedule_.reset();
  if (phase.profile) schedule_.emplace(*phase.profile, phase.arrivals, place, phase.seed);
  start_ = able_since_ = phase.start;
  frames_left_ = phase.max_frames;
  due_ = phase.start;
  if (place.index < phase.first_stream || place.index >= phase.end_stream) return stop();
  plan_next();
}

/// In a closed loop a frame is due as soon as it can be sent.
void StreamPace::plan_next() {
  if (!is_open_loop()) {
    if (frames_left_-- == 0) due_ = kNever;
    return;
  }
  const double seconds = schedule_->next();
  due_ = std::isfinite(seconds) ? start_ + seconds_of(seconds) : kNever;
}

uint64_t StreamPace::send(Time now, Books books) {
  books.tally.delay.add(ms_between(std::max(due_, able_since_), now));
  ++books.tally.sent;
  ++books.second.sent;
  in_flight_.push_back({.intended = is_open_loop() ? due_ : now, .sent = now});
  is_writing_ = true;
  plan_next();
  return ++last_id_;
}

void StreamPace::written(Time now) {
  is_writing_ = false;
  able_since_ = now;
}

void StreamPace::take(const v1::StreamFramesResponse& answer, Time now, Books books) {
  if (in_flight_.empty()) return;
  const InFlight frame = in_flight_.front();
  in_flight_.pop_front();
  able_since_ = now;
  if (frame.is_counted) {
    books.tally.late += answer.has_done();
    return;
  }
  if (answer.has_done()) {
    count_done(frame, answer.done(), now, books);
  } else if (answer.has_error()) {
    count_refused(answer.error(), now, books);
  } else {
    ++books.tally.skipped;
    ++books.second.skipped;
  }
}

void StreamPace::count_done(const InFlight& frame, const v1::FrameDone& done, Time now, Books books) {
  Tally& tally = books.tally;
  const v1::FrameMetrics& metrics = done.metrics();
  ++tally.answered;
  tally.latency.add(ms_between(frame.intended, now));
  tally.service.add(ms_between(frame.sent, now));
  tally.total.add(metrics.total_milliseconds());
  tally.queue.add(metrics.queue_milliseconds());
  tally.decode.add(metrics.decode_milliseconds());
  tally.engine.add(metrics.engine_milliseconds());
  tally.encode.add(metrics.encode_milliseconds());
  tally.contacts += done.contact_count();
  tally.bytes_in += metrics.bytes_in();
  tally.bytes_out += metrics.bytes_out();
  ++books.second.answered;
  books.second.latency.add(ms_between(frame.intended, now));
}

/// A closed loop waits as long as the daemon asks for, as a client would; an open one keeps its schedule.
void StreamPace::count_refused(const v1::FrameError& error, Time now, Books books) {
  load::add(books.tally.refused, client::code_name(error.code()), error.message());
  ++books.second.refused;
  if (!is_open_loop() && due_ != kNever) due_ = now + seconds_of(std::min(error.retry_after_seconds(), 60.0));
}

void StreamPace::give_up(Time now, Tally& tally) {
  for (InFlight& frame : in_flight_) {
    if (frame.is_counted) continue;
    frame.is_counted = true;
    ++tally.unanswered;
    tally.latency.add(ms_between(frame.intended, now));
  }
  for (; is_open_loop() && due_ <= now; plan_next()) {
    ++tally.unsent;
    tally.latency.add(ms_between(due_, now));
  }
  due_ = kNever;
}

}  // namespace collided::cli::load
