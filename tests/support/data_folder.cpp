#include "tests/support/data_folder.hpp"

#include <cstdlib>

namespace collided::test {

std::optional<std::filesystem::path> data_folder() {
  const char* set = std::getenv("COLLIDED_DATA");
  const std::filesystem::path folder = set ? set : COLLIDED_DEFAULT_DATA;
  if (!std::filesystem::is_directory(folder / "ccd-frames")) return std::nullopt;
  return folder;
}

}  // namespace collided::test
