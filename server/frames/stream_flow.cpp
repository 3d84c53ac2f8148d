// Flow control of one stream of frames.
#include "server/frames/stream_flow.hpp"

#include <stdexcept>
#include <string>

namespace collided::server {
namespace {

void check(bool is_allowed, const char* event) {
  if (!is_allowed) throw std::logic_error(std::string("a stream is in no state for the event: ") + event);
}

}  // namespace

void StreamFlow::open(uint32_t window) {
  if (is_ended()) return;
  check(phase_ == Phase::kUnopened, "open");
  phase_ = Phase::kOpening;
  window_ = window;
}

void StreamFlow::opened() {
  if (is_ended()) return;
  check(phase_ == Phase::kOpening, "opened");
  phase_ = Phase::kOpen;
}

void StreamFlow::submit(uint64_t frame_id, bool edits) {
  if (is_ended()) return;
  check(phase_ != Phase::kUnopened, "submit");
  ++in_flight_;
  if (edits) edit_ = frame_id;
}

bool StreamFlow::answer(uint64_t frame_id) {
  if (is_ended()) return false;
  check(phase_ == Phase::kOpen, "answer");
  if (edit_ != frame_id) return false;
  edit_.reset();
  return may_read();
}

bool StreamFlow::release() {
  if (is_ended()) return false;
  check(phase_ == Phase::kOpen && in_flight_ > 0, "release");
  const bool could_read = may_read();
  --in_flight_;
  return may_read() && !could_read;
}

void StreamFlow::half_close() { is_half_closed_ = true; }

void StreamFlow::end() { phase_ = Phase::kEnded; }

bool StreamFlow::may_read() const {
  if (!accepts()) return false;
  return phase_ == Phase::kUnopened || (in_flight_ < window_ && !edit_);
}

bool StreamFlow::is_complete() const {
  return is_half_closed_ && in_flight_ == 0 && (phase_ == Phase::kUnopened || phase_ == Phase::kOpen);
}

}  // namespace collided::server
