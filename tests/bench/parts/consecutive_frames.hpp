#pragma once
// A scene's frames as a simulator sends them: the first one whole, each later one where its vertices are at the end of
// its step, which begins where the last one ended.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

class ConsecutiveFrames {
 public:
  virtual ~ConsecutiveFrames() = default;
  virtual const std::vector<MeshSpec>& meshes() const = 0;
  virtual size_t count() const = 0;
  /// It borrows the frames' bytes.
  virtual FrameInput input(size_t i) const = 0;
};

/// How a procedural scene moves: from t = 0.8 on, or earlier where it would end before the last step; one that is too
/// short for all steps goes to and fro.
struct Pace {
  double step_seconds;
  size_t frames;

  /// Where the step ends, in [0, 1].
  double end_of(size_t i) const;
};

/// A procedural scene or a pair of real frames, which comes again and again. Null if there is none of that name.
std::unique_ptr<ConsecutiveFrames> consecutive_frames(const std::string& scene, double scale, const Pace& pace);

/// Of all scenes that are here.
std::vector<std::string> names_of_scenes();

}  // namespace collided::test
