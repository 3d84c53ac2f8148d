#pragma once
// Many scenes of one spec, stepped together: robot cells, or environments of reinforcement learning.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "client/cpp/client.hpp"

namespace collided::client {

/// Settings of a set.
struct SceneSetOptions {
  double lease_seconds = 0;  ///< as of Client::create_scene
  /// Bytes of the largest answer, from 64 KiB to the daemon's max_message_bytes (ServerLimits); 0: that limit.
  uint64_t max_answer_bytes = 0;
  /// Of the set's stream. Over shared memory its largest answers may need more than its `output_bytes`.
  LocalOptions local = {.output_bytes = uint64_t{32} << 20};
};

/// New positions of some worlds of a set, borrowed: packed little-endian x y z in the set's format, as they go on the
/// wire, of world after world, of each the vertices of `meshes` in their order.
struct SetUpdate {
  std::span<const std::byte> positions = {};        ///< t = 1
  std::span<const std::byte> start_positions = {};  ///< t = 0 (CCD), as many; empty: where the last frame ended
  std::span<const uint32_t> worlds = {};            ///< strictly ascending; empty: all
  /// Strictly ascending; empty: all, or all that are not static, whichever `positions` are of. A world's first frame
  /// has every mesh.
  std::span<const uint32_t> meshes = {};
};

/// Settings of one frame; those that are not set are the set's.
struct SetFrameOptions {
  v1::DetectionMode mode = v1::DETECTION_MODE_UNSPECIFIED;
  v1::Accuracy accuracy = v1::ACCURACY_UNSPECIFIED;
  std::optional<double> delta = {};
};

/// Contacts of one kind of all worlds in a frame; ids are counted in each world, as in a scene of its own.
struct WorldContacts : Contacts {
  /// Contacts [begin[i], begin[i + 1]) are those of the i-th world in the frame; one more entry than there are worlds.
  std::vector<uint64_t> begin;
};

/// The answer to a frame.
struct SetOutput : PerKind<WorldContacts> {
  uint64_t frame_id = 0;
  v1::FrameDone done;                   ///< metrics and totals of all worlds together
  std::vector<v1::WorldError> refused;  ///< worlds whose frames were refused, ascending; they are as they were
  std::optional<v1::FrameError> error;  ///< the whole frame was refused

  /// Throws Error if the whole frame was refused.
  void check() const;
};

class SceneSet;

/// A frame of one set, for a batch of several.
struct SetStep {
  SceneSet* set = nullptr;
  SetUpdate update = {};
  SetFrameOptions options = {};
};

/// A set on its own connection. One thread at a time. The scenes of a set are its worlds, numbered from 0: they have
/// the same meshes, whose triangles are held once, each has positions of its own, and none touches another. Its frames
/// go over a stream, which the first one opens, through shared memory where the daemon offers it; a call each where the
/// daemon grants no stream.
class SceneSet {
 public:
  /// Creates a set of `count` scenes of `spec` (which must have no meshes) and `meshes` where `client` leads. Throws
  /// Error as Client::create_scenes does, and INVALID_ARGUMENT for options out of range.
  static SceneSet create(Client& client, v1::SceneSpec spec, std::span<const MeshInput> meshes, uint32_t count,
                         const SceneSetOptions& options = {});
  SceneSet(SceneSet&&) noexcept;
  SceneSet& operator=(SceneSet&&) noexcept;
  /// The set lives until its lease ends.
  ~SceneSet();

  /// As it was created; its spec has no triangles.
  const v1::Scene& scene() const;
  /// Number of worlds.
  uint32_t worlds() const;
  /// One step of all worlds, or of those that the update names. Throws Error if the whole frame is refused; worlds
  /// that are refused by themselves are told in the output. Not while frames are in flight.
  SetOutput detect(const SetUpdate& update, const SetFrameOptions& options = {});
  /// The same in two halves, so that the next frame is made while the daemon works on this one: as many may be sent as
  /// the stream's window has before one is received, in their order; then send() waits. Throws Error.
  void send(const SetUpdate& update, const SetFrameOptions& options = {});
  /// The answer to the oldest frame that was sent. Throws Error if it is refused, and if there is none.
  SetOutput receive();
  /// Memory for the next frame's positions that the daemon reads directly, as FrameStream::input gives it; empty where
  /// any memory will do.
  std::span<std::byte> input(uint64_t bytes);
  /// Whether frames go through memory shared with the daemon.
  bool is_local();
  /// Deletes the set and frees its memory at once. Throws Error.
  void close();

 private:
  friend std::vector<SetOutput> detect_batch(std::span<const SetStep> steps);
  struct State;
  explicit SceneSet(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Deprecated: SceneSet::send() to each set, then receive() from each, takes about half the time.
///
/// Steps several sets of one daemon, 1 to 64, each once, in one call on the connection of the first. Outputs are in the
/// same order. A set that is refused harms no other. Throws Error where no frame was tried.
std::vector<SetOutput> detect_batch(std::span<const SetStep> steps);

}  // namespace collided::client
