#pragma once
// Real frames with exact truth: the data folder, which is not part of the repository.

#include <filesystem>
#include <optional>

#include "tests/support/case.hpp"

namespace collided::test {

struct RealFrames {
  const char* name;
  const char* folder;  ///< in the data folder
  const char* first;
  const char* second;
};
inline constexpr RealFrames kFunnelFrames{"cloth_funnel_227_228", "ccd-frames/cloth-funnel", "227.ply", "228.ply"};
inline constexpr RealFrames kBallFrames{"cloth_ball_92_93", "ccd-frames/cloth-ball", "cloth_ball92.ply",
                                        "cloth_ball93.ply"};

/// COLLIDED_DATA, or the folder `shared/data` next to the repository; nothing if it is absent.
std::optional<std::filesystem::path> data_folder();

Case load(const std::filesystem::path& data, const RealFrames& frames);

}  // namespace collided::test
