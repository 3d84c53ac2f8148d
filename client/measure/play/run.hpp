#pragma once
// Plays frames and reports what they found and cost.

#include <functional>
#include <string>
#include <vector>

#include "client/app/report/json.hpp"
#include "client/measure/play/play.hpp"

namespace collided::cli {

struct PlayOptions {
  Json input;                           ///< what is played, for the summary
  bool has_lines = false;               ///< a line for each frame, or an object in the summary
  std::vector<std::string> files = {};  ///< of the frames, for the lines
  bool json = false;
  std::function<void(const client::FrameOutput&)> take = {};  ///< each answer, besides
  std::string out = {};  ///< where `take` writes; if that is standard output, the report is not
};

/// If something ends it early, reports the frames so far, and throws what ended it.
void play_and_report(client::FrameStream& stream, const v1::Scene& scene, FrameSource source,
                     const PlayOptions& options);

}  // namespace collided::cli
