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

/// Carries one stream's messages to the daemon and back. One thread opens, sends and half-closes while another, not
/// always the same, reads and finally finishes; any thread may cancel. Calls on a broken stream return false; finish()
/// says why.
class FrameTransport {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr Time kNever = Time::max();
  enum class Arrival { kMessage, kNothing, kEnd };

  virtual ~FrameTransport() = default;

  /// Sends the opening message: called once, before all others. read() returns the answer.
  virtual bool open(const v1::OpenStream& open) = 0;
  /// Memory that the daemon reads directly, for `bytes` of the next frame's updates; valid for that frame alone. Only
  /// while a credit is free. Empty where the transport shares no memory; throws Error (RESOURCE_EXHAUSTED) past what a
  /// frame can need.
  virtual std::span<std::byte> input(uint64_t /*bytes*/) { return {}; }
  /// Sends `frame` with `updates` after its own; borrows both until it returns. Throws Error, and sends nothing, for a
  /// frame that this transport cannot carry.
  virtual bool send(const v1::Frame& frame, std::span<const FrameUpdate> updates) = 0;
  /// Waits for the daemon's next message. kNothing: none came by `deadline`; kEnd: the stream has ended, with or
  /// without an error.
  virtual Arrival read(v1::StreamFramesResponse& response, Time deadline) = 0;
  /// Bytes of the output region, valid until the frame's credit is used again. Throws Error (DATA_LOSS) for a range
  /// outside of it; over gRPC that is every range.
  virtual std::span<const std::byte> shared(const v1::SharedRange& range) const = 0;
  /// Bytes of an output region on the device, whose ranges only the device can read; 0: the host reads it.
  virtual uint64_t device_output_bytes() const { return 0; }
  /// Tells the daemon that no more frames will come.
  virtual void half_close() = 0;
  /// Ends the stream at once: read() returns kEnd soon.
  virtual void cancel() = 0;
  /// The error that ended the stream; nullopt if none did. Called once, after read() has returned kEnd.
  virtual std::optional<Error> finish() = 0;
};

}  // namespace collided::client
