#pragma once
// Frames in, contacts out: one stream to one scene.

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "client/cpp/contacts.hpp"
#include "client/cpp/error.hpp"
#include "client/cpp/frame_advance.hpp"
#include "client/cpp/frame_options.hpp"
#include "client/cpp/frame_update.hpp"
#include "client/cpp/mesh_pairs.hpp"
#include "client/cpp/positions.hpp"
#include "collided/v1/collision_service.pb.h"
#include "collided/v1/frame.pb.h"
#include "collided/v1/scene.pb.h"

namespace collided::client {

class FrameTransport;

/// The daemon's whole answer to one frame. Triangle pairs have elements and flags only.
struct FrameOutput : PerKind<Contacts> {
  /// The frame's contacts on the device, if the stream keeps them there (LocalOptions::output_cuda_ipc_handle): the
  /// first ones of the frame, complete now; those that had no room follow them, on the host. Valid until as many more
  /// frames have been sent as the window has.
  PerKind<DeviceContacts> on_device;
  uint64_t frame_id = 0;
  v1::FrameDone done;                        ///< metrics and totals
  FrameAdvance advance;                      ///< for move_along()
  std::vector<MeshPair> pairs;               ///< meshes that are not apart, by first, then second; if asked for
  PerKind<Contacts> limits;                  ///< what limits the way, with FrameOptions::limits; all columns are there
  std::optional<v1::FrameError> error;       ///< the frame was refused; the stream goes on
  std::vector<v1::WorldError> world_errors;  ///< of a set: worlds that were refused by themselves, ascending
  bool skipped = false;                      ///< a later frame replaced it (LATEST_WINS)

  /// Throws Error if the frame was refused.
  void check() const;
};

/// The keeper is a stream's own thread, which reads while no caller waits, so that answers keep flowing and the
/// daemon's pings are answered.
struct KeeperPace {
  std::chrono::milliseconds pause{20};  ///< between two reads
  int quiet_pauses = 150;               ///< after so many in a row without a waiting caller it keeps reading
};

class Features;

/// What a stream is told when it is opened.
struct StreamSetup {
  bool is_local = false;           ///< over shared memory
  std::string local_refusal = "";  ///< why not, although the daemon offers it
  KeeperPace keeper = {};
  /// Limits the wait for the first answer, and for the next one once no more frames will come.
  std::chrono::milliseconds deadline = std::chrono::seconds(60);
  std::string address = "";                            ///< of the daemon, for messages
  std::shared_ptr<const Features> features = nullptr;  ///< what the daemon lacks; null: nothing
};

/// One thread may send while another receives. Outputs come in frame order.
class FrameStream {
 public:
  /// Opens a stream over a fresh transport. Throws Error if the daemon refuses, DEADLINE_EXCEEDED if it does not answer
  /// in time.
  static FrameStream open(std::unique_ptr<FrameTransport> transport, const v1::OpenStream& open,
                          StreamSetup setup = {});
  FrameStream(FrameStream&&) noexcept;
  FrameStream& operator=(FrameStream&&) noexcept;
  /// Cancels what is in flight unless finish() was called.
  ~FrameStream();

  /// The scene as of the opening: last_frame_id is the last frame that was applied before this stream.
  const v1::Scene& scene() const;
  /// Whether positions and contacts go through memory shared with the daemon.
  bool is_local() const;
  /// Why they do not, although the daemon is on this host and offers it, for people; else empty.
  const std::string& local_refusal() const;
  /// How many frames may be in flight.
  uint32_t window() const;
  /// Seconds until the daemon, which is stopping, closes the stream; nothing unless it is stopping.
  std::optional<double> draining_deadline() const;
  /// Waits until fewer frames than the window are in flight, then sends. Outputs are kept until they are received.
  /// Throws Error once the stream has ended.
  void send(const v1::Frame& frame);
  /// The same from the caller's memory, which is borrowed until this returns, and not copied where the transport allows
  /// it.
  void send(uint64_t frame_id, std::span<const FrameUpdate> updates, const FrameOptions& options = {});
  /// Memory that the daemon reads directly: write the next frame's positions there and name it in the updates, and they
  /// are not copied. Waits for a credit. Call it as often as needed; each result is aligned to 64 bytes. Empty over
  /// gRPC, where any memory will do. Throws Error (RESOURCE_EXHAUSTED) past what a frame of the scene can need.
  std::span<std::byte> input(uint64_t bytes);
  /// Waits for the next output. Throws Error once the stream has ended, and if no frame is in flight, since a single
  /// thread would wait forever.
  FrameOutput receive();
  /// The same for at most `timeout`, whether or not a frame is in flight: for a thread that only receives. Nothing if
  /// no output came. Throws Error once the stream has ended.
  std::optional<FrameOutput> receive_within(std::chrono::milliseconds timeout);
  /// Tells the daemon that no more frames will come and waits until it ends the stream. Throws Error if it ends badly:
  /// DEADLINE_EXCEEDED if it neither answers a frame nor ends the stream for as long as a call may take.
  void finish();
  /// Ends the stream at once, from any thread: those that wait throw Error (CANCELLED), and frames in flight are
  /// withdrawn.
  void cancel();
  /// Whether the stream has ended. Outputs that came before can still be received.
  bool has_ended() const;

 private:
  struct State;
  explicit FrameStream(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collided::client
