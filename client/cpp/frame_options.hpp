#pragma once
// The options of a frame, and the message that carries them.

#include <cstdint>
#include <optional>
#include <vector>

#include "collided/v1/frame.pb.h"
#include "collided/v1/scene.pb.h"

namespace collided::client {

/// Settings of one frame; those that are not set are the scene's.
struct FrameOptions {
  v1::DetectionMode mode = v1::DETECTION_MODE_UNSPECIFIED;
  v1::Accuracy accuracy = v1::ACCURACY_UNSPECIFIED;
  std::optional<double> delta = {};
  v1::Report report = v1::REPORT_UNSPECIFIED;
  bool ignore_separating = false;
  bool advance = false;
  v1::AdvanceMode advance_mode = v1::ADVANCE_MODE_UNSPECIFIED;  ///< with `advance` alone
  bool limits = false;                                          ///< answer with what limits the way; likewise
  bool trial = false;
  std::optional<double> from_last_fraction = {};
  std::optional<v1::SceneEdit> edit = {};  ///< of edited_mesh() and removed_mesh(), and of pairs of meshes
  /// Only for sets, whose frames have one update: as in SetUpdate (client/cpp/batch/scene_set.hpp).
  std::vector<uint32_t> worlds = {}, meshes = {};
};

/// Returns a frame with these options, without updates.
v1::Frame frame_head(uint64_t frame_id, const FrameOptions& options);

/// Copies all fields but the updates, whose positions are large.
void copy_head(const v1::Frame& from, v1::Frame& to);

}  // namespace collided::client
