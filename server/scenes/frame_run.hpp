#pragma once
// One frame from its positions to its contacts, whichever way it came. No gRPC here.

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "server/ops/clock.hpp"
#include "server/scenes/turns.hpp"

namespace collided::server {

class Scene;

/// A mesh that a frame brings positions for.
struct BroughtMesh {
  uint32_t mesh = 0;
  bool is_whole = true;  ///< of all its vertices
};

/// A frame on its way to the engine.
struct PendingFrame {
  uint64_t frame_id = 0;
  FrameInput input;
  std::vector<BroughtMesh> brings;
  std::exception_ptr refusal = {};          ///< what is wrong with it already
  std::shared_ptr<const void> memory = {};  ///< keeps what `input` refers to
  std::chrono::steady_clock::time_point arrival = std::chrono::steady_clock::now();
  double decode_milliseconds = 0;
  uint64_t bytes_in = 0;  ///< of positions and indices
};

/// What a frame cost outside the pipeline.
struct FrameCost {
  double total_milliseconds = 0, queue_milliseconds = 0, decode_milliseconds = 0, engine_milliseconds = 0,
         encode_milliseconds = 0;
  uint64_t device_bytes = 0, bytes_in = 0, bytes_out = 0;
};

struct AnsweredFrame {
  uint64_t frame_id = 0;
  std::chrono::steady_clock::time_point arrival;
  FrameResult result;
  FrameCost cost;  ///< encode_milliseconds, bytes_out and total_milliseconds come with the encoding
};

/// Told of everything that happens to scenes and their frames; from any thread.
class SceneObserver {
 public:
  virtual ~SceneObserver() = default;
  /// Its cost is complete.
  virtual void answered(const Scene& scene, const AnsweredFrame& frame) = 0;
  virtual void refused(const Scene& scene, uint64_t frame_id, const std::exception_ptr& error) = 0;
  virtual void skipped(const Scene& scene, uint64_t frame_id) = 0;
  /// Its lease has run out, and it is deleted.
  virtual void expired(const Scene& scene) = 0;
  /// The engine said so of the scene's device.
  virtual void device_failed(const Scene& scene, const std::string& why) = 0;
};

/// What all scenes share. What it refers to outlives them.
struct SceneSurroundings {
  Turns& turns;
  SceneObserver& observer;
  std::string endpoint = {};  ///< address that clients are told to stream to; empty: the one they used
  Now now = Clock::now;       ///< of leases and idle streams
};

/// Waits for a turn and applies the frame, on the scene's worker thread; on CPU cores it gives way to other clients
/// meanwhile. Throws what the engine throws, Cancelled, and LimitExceeded for a frame that runs longer than its
/// client's frames may.
AnsweredFrame run_frame(Scene& scene, PendingFrame& frame, const std::function<bool()>& cancelled);

double milliseconds_since(std::chrono::steady_clock::time_point start);

}  // namespace collided::server
