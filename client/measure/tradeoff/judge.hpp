#pragma once
// Reported contacts judged by the truth.

#include "client/cpp/frame_stream.hpp"
#include "client/measure/tradeoff/result.hpp"
#include "client/measure/tradeoff/truth.hpp"

namespace collided::cli {

/// What EXACT's time of impact of a contact that it was certain of without exact arithmetic may be early by.
inline constexpr double kBoundedTime = 1e-9;
/// A delta that makes EXACT decide in exact arithmetic all that it is not certain of from t = 0 on.
inline constexpr double kWideDelta = 1e30;

/// The answers of the level EXACT with the daemon's own delta and with kWideDelta as truth: the first has a close lower
/// bound of every time of impact, the second exact ones (within 2^-60) wherever it gives any but 0. Throws
/// std::runtime_error if they contradict each other.
Truth exact_truth(const client::FrameOutput& close, const client::FrameOutput& wide);

Score judge(const Truth& truth, const client::FrameOutput& output);

}  // namespace collided::cli
