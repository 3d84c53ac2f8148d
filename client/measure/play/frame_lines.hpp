#pragma once
// What each frame of a stream found: a line each on standard output, or an array of objects.

#include <string>
#include <vector>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// How `FrameLines` shows frames.
struct LineOptions {
  v1::SceneSpec spec = {};
  int frames = 0;
  std::vector<std::string> files = {};  ///< of the frames, by id from 1; may be empty
  bool json = false;                    ///< keeps objects instead of printing lines
};

class FrameLines {
 public:
  explicit FrameLines(LineOptions options) : options_(std::move(options)) {}
  /// Prints the line at once: whoever reads it watches. Throws OutputClosed.
  void add(const client::FrameOutput& output);
  /// Whether lines go to a terminal, where they show how far the stream is.
  bool show_progress() const;
  const Json& json() const { return frames_; }

 private:
  LineOptions options_;
  Json frames_ = Json::array();
  int shown_ = 0;
};

}  // namespace collided::cli
