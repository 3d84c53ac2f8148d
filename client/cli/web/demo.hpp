#pragma once
// A motion that is played to and fro, so that there is something to see without a simulator.

#include <stop_token>

#include "client/app/input/motion.hpp"
#include "client/cpp/frame_stream.hpp"

namespace collided::cli {

/// The frame of a motion of `frames` that comes `step` steps after the first: to the last one, back, and so on.
int frame_to_and_fro(uint64_t step, int frames);

/// Sends at most `rate` frames a second until it is told to stop. Throws Error if one is refused or the stream ends,
/// Interrupted, and what reading the motion throws.
void play_to_and_fro(client::FrameStream& stream, const Motion& motion, const v1::SceneSpec& spec, double rate,
                     const std::stop_token& stop);

}  // namespace collided::cli
