#pragma once
// What a FrameStream runs over: a gRPC call, or the daemon's local socket with shared memory.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "client/cpp/error.hpp"
#include "client/cpp/frame_update.hpp"
#include "collided/v1/collision_service.pb.h"

namespace collided::client {

/// One stream's way to the daemon and back. One thread opens, sends and half-closes while another one, not always the
/// same, reads and then finishes; cancel() may come from any thread. A broken stream shows as false: finish() then
/// tells why.
class FrameTransport {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr Time kNever = Time::max();
  enum class Arrival { kMessage, kNothing, kEnd };

  virtual ~FrameTransport() = default;

  /// Sends the opening, once and first; read() brings the answer.
  virtual bool open(const v1::OpenStream& open) = 0;
  /// Memory that the daemon reads directly, for `bytes` of the next frame's updates; its parts can be sent once, in
  /// that frame. Only while a credit is free. Empty where the transport shares none; throws Error (RESOURCE_EXHAUSTED)
  /// past what a frame can need.
  virtual std::span<std::byte> input(uint64_t /*bytes*/) { return {}; }
  /// Sends `frame` with `updates` after its own ones. Nothing of either is looked at once it has returned. Throws Error
  /// for a frame that this transport cannot carry, without sending anything.
  virtual bool send(const v1::Frame& frame, std::span<const FrameUpdate> updates) = 0;
  /// Waits for the daemon's next message, but not past `deadline`: kNothing. kEnd at the end of the stream, good or
  /// bad.
  virtual Arrival read(v1::StreamFramesResponse& response, Time deadline) = 0;
  /// Bytes of the output region, valid until the frame's credit is used again. Throws Error (DATA_LOSS) for a range
  /// that does not lie in it; over gRPC, that is every one.
  virtual std::span<const std::byte> shared(const v1::SharedRange& range) const = 0;
  /// Tells the daemon that no more frames come.
  virtual void half_close() = 0;
  /// Ends the stream at once: read() returns kEnd soon.
  virtual void cancel() = 0;
  /// Why the stream ended, once, after read() has returned kEnd; nothing for a good end.
  virtual std::optional<Error> finish() = 0;
};

}  // namespace collided::client
