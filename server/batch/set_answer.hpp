#pragma once
// The answer to a set's frame: contacts of all worlds in one array of each field, refusals world by world.

#include <atomic>
#include <cstdint>
#include <vector>

#include "collided/v1/batch.pb.h"
#include "server/frames/frame.hpp"
#include "server/refusals/status.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// The failure with its field's path in the request, where it names one of the frame's.
Failure at_frame(Failure failure, size_t index);

/// Bytes that an answer may still have. Thread-safe.
class AnswerBytes {
 public:
  explicit AnswerBytes(uint64_t max) : max_(max), left_(max) {}
  /// Throws LimitExceeded, naming max_answer_bytes, for more than are left.
  void take(uint64_t frame_id, uint64_t bytes);

 private:
  const uint64_t max_;
  std::atomic<uint64_t> left_;
};

/// Completes the frame's cost. `worlds`: in the frame; `index`: of it in the request. Throws LimitExceeded.
void fill_answer(const Scene& set, AnsweredFrame& frame, const std::vector<uint32_t>& worlds, size_t index,
                 AnswerBytes& bytes, pb::SetAnswer* out);

}  // namespace collided::server
