#pragma once
// Pairs of consecutive frames of simulations, with the exact truth of every pair of features that collides.

#include <filesystem>
#include <ostream>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

enum class FrameSource { kOwn, kDataFolder };

struct RealFrames {
  const char* name;
  FrameSource source;
  const char* folder;  ///< in tests/support/data, or in the data folder
  const char* first;
  const char* second;
};

/// Our own, always present: see data/cloth_drape/README.md.
inline constexpr RealFrames kDrapeFrames{"cloth_drape", FrameSource::kOwn, "cloth_drape", "before.ply", "after.ply"};

inline constexpr RealFrames kFunnelFrames{"cloth_funnel_227_228", FrameSource::kDataFolder, "ccd-frames/cloth-funnel",
                                          "227.ply", "228.ply"};
inline constexpr RealFrames kBallFrames{"cloth_ball_92_93", FrameSource::kDataFolder, "ccd-frames/cloth-ball",
                                        "cloth_ball92.ply", "cloth_ball93.ply"};

/// Their names in GoogleTest.
inline void PrintTo(const RealFrames& frames, std::ostream* out) { *out << frames.name; }

/// Whether load() can read them: false for those of an absent data folder.
bool are_here(const RealFrames& frames);

/// Those of the data folder; none if it is absent.
std::vector<RealFrames> frames_of_data_folder();

/// The parent of their folders `frames` and `truth`. Throws std::runtime_error if absent.
std::filesystem::path folder_of(const RealFrames& frames);

/// One mesh. Throws std::runtime_error if absent.
Case load(const RealFrames& frames);

}  // namespace collided::test
