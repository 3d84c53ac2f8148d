#include "tests/support/data_folder.hpp"

#include <cstdlib>

#include "client/scenes/mesh_files/mesh_file.hpp"

namespace collided::test {

std::optional<std::filesystem::path> data_folder() {
  const char* set = std::getenv("COLLIDED_DATA");
  const std::filesystem::path folder = set ? set : COLLIDED_DEFAULT_DATA;
  if (!std::filesystem::is_directory(folder / "ccd-frames")) return std::nullopt;
  return folder;
}

Case load(const std::filesystem::path& data, const RealFrames& frames) {
  const std::filesystem::path folder = data / frames.folder / "frames";
  scenes::MeshFile first = scenes::read_mesh(folder / frames.first);
  scenes::MeshFile second = scenes::read_mesh(folder / frames.second);
  Case c;
  c.name = frames.name;
  add_mesh(c, std::move(first.triangles), std::move(first.positions), std::move(second.positions));
  return c;
}

}  // namespace collided::test
