#include "tests/support/frames/real_frames.hpp"

#include <stdexcept>
#include <utility>

#include "client/scenes/mesh_files/mesh_file.hpp"
#include "tests/support/data_folder.hpp"

namespace collided::test {

bool are_here(const RealFrames& frames) { return frames.source == FrameSource::kOwn || data_folder(); }

std::vector<RealFrames> frames_of_data_folder() {
  if (!data_folder()) return {};
  return {kFunnelFrames, kBallFrames};
}

std::filesystem::path folder_of(const RealFrames& frames) {
  if (frames.source == FrameSource::kOwn) return std::filesystem::path(COLLIDED_OWN_DATA) / frames.folder;
  if (const auto data = data_folder()) return *data / frames.folder;
  throw std::runtime_error(std::string(frames.name) + ": " + kNoDataFolder);
}

Case load(const RealFrames& frames) {
  const std::filesystem::path folder = folder_of(frames) / "frames";
  scenes::MeshFile first = scenes::read_mesh(folder / frames.first);
  scenes::MeshFile second = scenes::read_mesh(folder / frames.second);
  Case c;
  c.name = frames.name;
  add_mesh(c, std::move(first.triangles), std::move(first.positions), std::move(second.positions));
  return c;
}

}  // namespace collided::test
