#pragma once
// Frames in, contacts out: one stream to one scene.

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "client/cpp/contacts.hpp"
#include "client/cpp/error.hpp"
#include "client/cpp/frame_update.hpp"
#include "client/cpp/positions.hpp"
#include "collided/v1/collision_service.pb.h"
#include "collided/v1/frame.pb.h"
#include "collided/v1/scene.pb.h"

namespace collided::client {

class FrameTransport;

/// All that the daemon answered to one frame.
struct FrameOutput {
  uint64_t frame_id = 0;
  Contacts vertex_triangle;
  Contacts edge_edge;
  Contacts triangle_triangle;           ///< elements and flags alone
  v1::FrameDone done;                   ///< metrics and totals
  std::optional<v1::FrameError> error;  ///< the frame was refused; the stream goes on
  bool skipped = false;                 ///< a later frame took its place (LATEST_WINS)

  /// Throws the refusal as an Error.
  void check() const;
};

/// What one frame alone asks for; what is not set is as in the scene's spec.
struct FrameOptions {
  v1::Accuracy accuracy = v1::ACCURACY_UNSPECIFIED;
  std::optional<double> delta = {};
  v1::Report report = v1::REPORT_UNSPECIFIED;
};

/// How a stream reads for itself while nobody waits for it: so that answers move, and the daemon's pings are answered.
struct KeeperPace {
  std::chrono::milliseconds pause{20};  ///< until it looks again
  int quiet_pauses = 150;               ///< so many in a row without anybody who waits, and it stays at the connection
};

/// What a stream is told of itself.
struct StreamSetup {
  bool is_local = false;           ///< over shared memory
  std::string local_refusal = "";  ///< why not, though the daemon offers it
  KeeperPace keeper = {};
};

/// One thread may send while another receives. Outputs come in the order of the frames.
class FrameStream {
 public:
  /// Opens a stream over a transport that has sent nothing yet. Throws Error with the daemon's refusal.
  static FrameStream open(std::unique_ptr<FrameTransport> transport, const v1::OpenStream& open,
                          StreamSetup setup = {});
  FrameStream(FrameStream&&) noexcept;
  FrameStream& operator=(FrameStream&&) noexcept;
  /// Cancels what is in flight unless finish() was called.
  ~FrameStream();

  /// As of the opening: its last_frame_id is the last frame that was applied before this stream.
  const v1::Scene& scene() const;
  /// Whether positions and contacts travel through memory that is shared with the daemon.
  bool is_local() const;
  /// Why they do not although the daemon is on this host and offers it, for people to read; else empty.
  const std::string& local_refusal() const;
  /// Frames that may be in flight.
  uint32_t window() const;
  /// Seconds until the daemon, which is about to stop, closes the stream; nothing while it stays.
  std::optional<double> draining_deadline() const;
  /// Waits until fewer frames than the window are in flight, then sends. Throws Error once the stream has ended.
  /// Outputs are kept until receive() takes them.
  void send(const v1::Frame& frame);
  /// The same from the caller's memory, without a copy where the transport allows it; the updates' bytes are not needed
  /// any more once this returns.
  void send(uint64_t frame_id, std::span<const FrameUpdate> updates, const FrameOptions& options = {});
  /// Memory that the daemon reads directly: what is written there and named in the next frame's updates is not copied
  /// on its way. Waits for a credit. `bytes` at a time, as often as needed; starts are aligned to 64. Empty over gRPC,
  /// where any memory will do. Throws Error (RESOURCE_EXHAUSTED) past what a frame of the scene can bring.
  std::span<std::byte> input(uint64_t bytes);
  /// Waits for the next output. Throws Error once the stream has ended, and if nothing is in flight, for which a single
  /// thread would wait for ever.
  FrameOutput receive();
  /// The same for at most so long, whether or not a frame is in flight yet: for a thread of its own that receives.
  /// Nothing if no output came. Throws Error once the stream has ended.
  std::optional<FrameOutput> receive_within(std::chrono::milliseconds patience);
  /// Tells the daemon that no more frames come, waits for its end and throws Error if it is a bad one.
  void finish();

 private:
  struct State;
  explicit FrameStream(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collided::client
