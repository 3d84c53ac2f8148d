#pragma once
// The frames of all streams as messages: positions are encoded once and shared, only each frame's id is its own.

#include <grpcpp/support/byte_buffer.h>

#include <vector>

#include "client/measure/load/drive/motion.hpp"
#include "collided/v1/scene.pb.h"

namespace collided::cli::load {

class Messages {
 public:
  /// `spec`: of the scenes.
  Messages(const Motion& motion, const v1::SceneSpec& spec);
  /// A StreamFramesRequest. Ids count from 1; the first frame has the static meshes, too.
  grpc::ByteBuffer frame(uint64_t id) const;
  /// Bytes of positions of a frame after the first.
  uint64_t bytes() const { return later_.front().size(); }

 private:
  std::vector<grpc::Slice> later_;  ///< the updates of each frame of the motion
  grpc::Slice first_;
};

}  // namespace collided::cli::load
