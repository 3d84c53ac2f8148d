#pragma once
// The frames of a scene as an observer sees them, whoever sends them.

#include <memory>
#include <string>
#include <vector>

#include "client/cpp/frame_stream.hpp"
#include "collided/v1/collision_service.pb.h"

namespace collided::client {

class ChannelFactory;

/// What a watcher sees, and how often. Values are checked by the daemon.
struct WatchOptions {
  uint32_t frame_interval = 0;         ///< every so many frames; 0: every one
  double max_frames_per_second = 0;    ///< 0: as many as the watcher reads
  uint32_t max_contacts_per_kind = 0;  ///< the first in canonical order; 0: only their numbers
  std::vector<uint32_t> meshes = {};   ///< indices of those whose positions are sent
  uint32_t vertex_stride = 0;          ///< positions of every so many vertices; 0: as many as fit in a message
};

/// One frame. Of its contacts it has at most those that the options ask for; `done` has the frame's own totals.
struct WatchedFrame : FrameOutput {
  uint64_t skipped_frames = 0;    ///< that were not sent since the last one
  uint64_t omitted_contacts = 0;  ///< that the frame has besides these
  uint64_t edit_count = 0;        ///< of the scene; where it has risen, Client::get_scene tells its meshes now
  std::vector<v1::VertexSample> positions;
};

/// One thread reads; any may cancel.
class Watcher {
 public:
  /// Throws Error if the daemon refuses, or lacks what is asked for; null: it lacks nothing.
  static Watcher open(const ChannelFactory& channels, const std::string& scene_id, const WatchOptions& options,
                      const std::shared_ptr<const Features>& features = nullptr);
  Watcher(Watcher&&) noexcept;
  Watcher& operator=(Watcher&&) noexcept;
  /// Ends the watch.
  ~Watcher();

  /// The scene as of the opening, without triangles.
  const v1::Scene& scene() const;
  /// Of all positions; 0 if none were asked for.
  uint32_t vertex_stride() const;
  /// Waits for the next frame. Throws Error once the watch has ended: NOT_FOUND if the scene is gone, CANCELLED after
  /// cancel().
  WatchedFrame receive();
  /// Makes receive() throw.
  void cancel();

 private:
  struct State;
  explicit Watcher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collided::client
