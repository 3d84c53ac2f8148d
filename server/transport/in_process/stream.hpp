#pragma once
// A stream of frames for a caller in this process: no socket, no messages on a wire. Positions are copied once, to
// where the backend reads them, or written there; contacts stay where the engine has put them until the caller has read
// them.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collided/v1/collision_service.pb.h"
#include "server/auth/authenticator.hpp"
#include "server/frames/intake.hpp"
#include "server/frames/messages.hpp"
#include "server/frames/session.hpp"
#include "server/frames/stream_flow.hpp"
#include "server/ops/metrics.hpp"
#include "server/scenes/scene_host.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// What streams are opened on; outlives them.
struct InProcessRules {
  SceneHost& host;
  const Authenticator& authenticator;
  Metrics& metrics;
};

/// A frame of a caller that keeps `arrays` (one entry for each update, in place of the message's own, or empty) until
/// submit() returns.
struct LentFrame {
  pb::Frame message;
  std::vector<PlacedPositions> arrays;
};

/// One answer. The offset of a range in it is an address, valid as long as `memory` is kept.
struct InProcessAnswer {
  pb::StreamFramesResponse message;
  std::shared_ptr<const void> memory;
};

/// One thread sends while another reads; any may cancel.
class InProcessStream final : public FrameSink, public std::enable_shared_from_this<InProcessStream> {
 public:
  using Time = std::chrono::steady_clock::time_point;
  enum class Arrival { kMessage, kNothing, kEnd };

  /// Throws what StreamFrames refuses an opening with.
  static std::shared_ptr<InProcessStream> open(const pb::OpenStream& open, const InProcessRules& rules);

  /// Memory for positions of the next frame, which are not copied from there. Waits while an edit is in flight. Throws
  /// LimitExceeded past what a frame of the scene can have, and where there is no memory.
  std::span<std::byte> input(uint64_t bytes);
  /// Sends a frame, of which no more than the window may be unanswered. Waits while an edit is in flight. False after
  /// half_close(), and once the stream has ended.
  bool submit(LentFrame frame);
  /// Waits for the next answer until `deadline`; Time::max() is for ever.
  Arrival read(InProcessAnswer& answer, Time deadline);
  /// No more frames will come: the stream ends once all are answered.
  void half_close();
  /// Ends the stream at once. Nothing calls it any more afterwards.
  void cancel();
  /// Why it ended; OK after half_close(). Once read() has returned kEnd.
  Failure end() const;

  void opened(const Scene& scene) override;
  void answered(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame) override;
  void refused(uint64_t frame_id, const Failure& failure) override;
  void skipped(uint64_t frame_id) override;
  void draining(double seconds) override;
  void ended(const std::exception_ptr& why) override;

 private:
  explicit InProcessStream(const InProcessRules& rules) : rules_(rules) {}

  void begin(std::shared_ptr<FrameSession> session);
  void await_edit();
  void take_slot(uint64_t bytes);
  std::span<std::byte> take_room(uint64_t bytes);
  void place(LentFrame& frame, IncomingFrame& incoming);
  std::span<const std::byte> place(std::span<const std::byte> bytes, std::string* otherwise);
  void push(InProcessAnswer answer, std::optional<uint64_t> answered_frame = {});
  // `_locked`: the caller holds mutex_.
  void end_if_complete_locked();
  void end_locked(const Failure& why);

  const InProcessRules rules_;
  const CallIds ids_ = parse_ids({}, {});
  StreamTerms terms_;  // set before the session, as the id
  std::string scene_id_;

  std::shared_ptr<FrameSlot> slot_;  // of the next frame; null: none yet; owned by the sending thread, as the next two
  std::span<std::byte> room_;        // of the slot
  uint64_t used_ = 0;                // bytes of the room that are taken

  mutable std::mutex mutex_;               // guards what follows
  std::shared_ptr<FrameSession> session_;  // set by open(), and then never again
  std::shared_ptr<void> ticket_;           // counts the stream as open
  std::condition_variable changed_;
  std::deque<InProcessAnswer> answers_;
  StreamFlow flow_;             // an answer has left once read() can return it
  std::optional<Failure> end_;  // once it has ended
};

}  // namespace collided::server
