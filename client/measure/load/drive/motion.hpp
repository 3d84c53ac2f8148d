#pragma once
// What all streams play, back and forth: a procedural scene, or recorded frames.

#include "client/app/input/motion.hpp"
#include "client/measure/load/settings.hpp"

namespace collided::cli::load {

/// One frame or more. Files are in the order given, and kept in memory. Throws std::invalid_argument or
/// std::runtime_error naming what is wrong.
Motion make_motion(const InputSettings& input);

/// Which of `frames` frames the `n`-th frame of a stream is, both from 0: first forth, then back, so that no mesh
/// jumps.
size_t place_in_motion(uint64_t n, size_t frames);

}  // namespace collided::cli::load
