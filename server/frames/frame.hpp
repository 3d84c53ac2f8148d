#pragma once
// A frame before and after the engine.

#include <cstdint>
#include <exception>
#include <memory>
#include <vector>

#include "gpu/detector.hpp"
#include "server/ops/clock.hpp"
#include "server/scenes/scene/plan.hpp"

namespace collided::server {

/// A mesh that a frame has positions for.
struct UpdatedMesh {
  uint32_t mesh = 0;
  bool is_whole = true;       ///< all its vertices
  bool has_positions = true;  ///< that later frames of a rigid mesh transform
};

/// A frame on its way to the engine.
struct PendingFrame {
  uint64_t frame_id = 0;
  FrameInput input;
  std::vector<UpdatedMesh> meshes;
  std::vector<uint32_t> worlds = {};  ///< of a set: those in the frame, all of which have `meshes`
  FrameBasis basis = {};
  std::exception_ptr refusal = {};          ///< why it cannot be applied; null: no error so far
  std::shared_ptr<const void> memory = {};  ///< keeps alive what `input` refers to
  Clock::time_point arrival = Clock::now();
  double decode_milliseconds = 0;
  uint64_t bytes_in = 0;      ///< of positions and indices
  bool tells_worlds = false;  ///< the answer has the world of each contact
};

/// What a frame cost outside the engine's stages.
struct FrameCost {
  double total_milliseconds = 0, queue_milliseconds = 0, decode_milliseconds = 0, engine_milliseconds = 0,
         encode_milliseconds = 0;
  uint64_t device_bytes = 0, bytes_in = 0, bytes_out = 0;
};

struct AnsweredFrame {
  uint64_t frame_id = 0;
  Clock::time_point arrival;
  FrameResult result;
  FrameCost cost;  ///< encode_contacts() adds encode_milliseconds, total_milliseconds and bytes_out
  bool tells_worlds = false;
};

}  // namespace collided::server
