#pragma once
// Plays frames through a stream.

#include <functional>
#include <optional>

#include "client/cpp/frame_stream.hpp"

namespace collided::cli {

/// Frames to send, one after the other.
struct FrameSource {
  int frames = 0;                                  ///< how many there are
  std::function<std::optional<v1::Frame>()> next;  ///< nothing after the last one
  bool is_quiet = false;                           ///< shows no progress
};

/// Sends all frames, as many at a time as the stream's window allows, and passes on each answer, in order. Throws what
/// `next` and `take` throw, Error once the stream has ended, and Interrupted. If `next` throws, the frames that were
/// sent are answered and passed on before.
void play(client::FrameStream& stream, const FrameSource& source, const std::function<void(client::FrameOutput)>& take);

}  // namespace collided::cli
