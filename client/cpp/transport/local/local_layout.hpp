#pragma once
// The layout of the memory that a stream shares with the daemon.

#include <cstdint>

#include "client/cpp/local_options.hpp"
#include "collided/v1/scene.pb.h"

namespace collided::client {

struct LocalLayout {
  uint32_t window = 2;
  uint64_t frame_bytes = 0;   ///< of input for each frame in flight; a multiple of 4096
  uint64_t output_bytes = 0;  ///< of contacts for all frames in flight; a multiple of 4096
  bool is_device_output = false;

  /// Of the file that both sides map.
  uint64_t input_in_file() const { return window * frame_bytes; }
  uint64_t output_in_file() const { return is_device_output ? 0 : output_bytes; }
};

/// Room for any frame of the scene, or of the set.
LocalLayout local_layout(const v1::Scene& scene, uint32_t window, const LocalOptions& options);

}  // namespace collided::client
