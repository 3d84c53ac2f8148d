#include "server/ops/supervisor/ready_file.hpp"

#include <string.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace collided::server {

namespace fs = std::filesystem;

std::string ready_file_obstacle(const std::string& path) {
  if (path.empty()) return "";
  std::error_code ignored;
  const fs::file_status there = fs::symlink_status(path, ignored);
  if (fs::exists(there) && !fs::is_regular_file(there)) return "what is there is not a regular file";
  const fs::path parent = fs::path(path).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  if (!fs::is_directory(folder, ignored)) return "there is no folder " + folder;
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    return "its folder cannot be written to: " + std::string(strerror(errno));
  return "";
}

void write_ready_file(const std::string& path, const std::vector<std::string>& addresses) {
  if (path.empty()) return;
  const std::string part = path + ".part";
  std::ofstream file(part);
  for (const auto& address : addresses) file << address << '\n';
  file.close();
  std::error_code error;
  if (file) fs::rename(part, path, error);
  if (!file || error) throw std::runtime_error("cannot write the ready file " + path);
}

}  // namespace collided::server
