#pragma once
// Controls the flow of one stream of frames, by the same rules on every transport: credits, the order of edits,
// half-close, and what a client must still be sent before its stream may end. Transports move bytes and hold a lock.
// They report events here, and ask whether to read on and whether to end. This class has no bytes, threads or clocks.
//
// A stream has one of four phases, and three more facts: whether it is half-closed, how many frames are in flight, and
// whose edit is pending.
//
//   event            | unopened         | opening              | open                           | ended
//   -----------------+------------------+----------------------+--------------------------------+--------
//   open(window)     | becomes opening  | misuse               | misuse                         | ignored
//   opened()         | misuse           | becomes open         | misuse                         | ignored
//   submit(id, edit) | misuse           | one more in flight,  | one more in flight,            | ignored
//                    |                  | perhaps an edit      | perhaps an edit                |
//   answer(id)       | misuse           | misuse               | ends the edit of that frame    | ignored
//   release()        | misuse           | misuse               | one fewer in flight            | ignored
//                    |                  |                      | (misuse if there is none)      |
//   half_close()     | no further reads | no further reads     | no further reads               | ignored
//   end()            | becomes ended    | becomes ended        | becomes ended                  | ignored
//
//   reads on if      | not half-closed  | not half-closed, fewer in flight than the window,     | never
//                    |                  | and no edit pending                                   |
//   is complete if   | half-closed      | never                | half-closed, none in flight    | never
//
// Events after the end are ignored because a scene's worker may be about to report one. Misuse throws std::logic_error.

#include <cstdint>
#include <optional>

namespace collided::server {

class StreamFlow {
 public:
  /// The client's opening is accepted. At most `window` of its frames may be unanswered.
  void open(uint32_t window);
  /// The client is sent that its stream is open.
  void opened();
  /// A frame of the client's was admitted. `edits`: it edits the scene, so that later frames can only be checked
  /// against what it makes of the scene.
  void submit(uint64_t frame_id, bool edits);
  /// The outcome of a frame is known. Returns true if the transport may read again, and could not before.
  bool answer(uint64_t frame_id);
  /// The answer of a frame has left: one credit more. Returns true if the transport may read again, and could not
  /// before.
  bool release();
  /// The client sends nothing more.
  void half_close();
  /// The stream has ended, for whatever reason.
  void end();

  uint32_t window() const { return window_; }
  bool is_ended() const { return phase_ == Phase::kEnded; }
  /// True unless the stream has ended or the client has half-closed.
  bool accepts() const { return !is_ended() && !is_half_closed_; }
  bool has_edit() const { return edit_.has_value(); }
  /// True if the next message may be read.
  bool may_read() const;
  /// True if the client has half-closed and is owed nothing more.
  bool is_complete() const;

 private:
  enum class Phase { kUnopened, kOpening, kOpen, kEnded };

  Phase phase_ = Phase::kUnopened;
  bool is_half_closed_ = false;
  uint32_t window_ = 0;
  uint64_t in_flight_ = 0;        // frames whose answer has not left
  std::optional<uint64_t> edit_;  // the frame with an edit whose outcome is not known
};

}  // namespace collided::server
