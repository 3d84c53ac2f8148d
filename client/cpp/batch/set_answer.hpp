#pragma once
// What a daemon answers to a set's frame, as the caller gets it.

#include <span>

#include "client/cpp/batch/scene_set.hpp"
#include "collided/v1/batch.pb.h"

namespace collided::client {

/// Of DetectBatch, for so many worlds in the frame. Throws Error (DATA_LOSS) where it makes no sense.
SetOutput read_answer(v1::SetAnswer&& answer, size_t worlds);

/// Of a stream, for these worlds in the frame. Throws Error (DATA_LOSS) likewise.
SetOutput read_output(FrameOutput&& output, std::span<const uint32_t> worlds);

}  // namespace collided::client
