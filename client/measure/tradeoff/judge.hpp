#pragma once
// Reported contacts judged by the truth.

#include "client/cpp/frame_stream.hpp"
#include "client/measure/tradeoff/result.hpp"
#include "client/measure/tradeoff/truth.hpp"

namespace collided::cli {

/// How early EXACT's time of impact may be for a contact that it decided without exact arithmetic.
inline constexpr double kBoundedTime = 1e-9;
/// A delta that makes EXACT decide everything in exact arithmetic unless it is certain at t = 0.
inline constexpr double kWideDelta = 1e30;

/// The truth from two answers of the level EXACT: with the daemon's own delta it gives close lower bounds of the times
/// of impact, with kWideDelta exact ones (within 2^-60) wherever they are not 0. Throws std::runtime_error if the
/// answers contradict each other.
Truth exact_truth(const client::FrameOutput& close, const client::FrameOutput& wide);

/// Throws std::runtime_error if the contacts lack times of impact or stencils.
Score judge(const Truth& truth, const client::FrameOutput& output);

}  // namespace collided::cli
