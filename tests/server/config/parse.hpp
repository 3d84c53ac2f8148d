#pragma once
// Reads a command line, as main does.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "server/config/config.hpp"

namespace collided::server {

inline std::vector<const char*> command_line(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "collided");
  return arguments;
}

inline ParsedConfig parse(const std::vector<const char*>& arguments) {
  const auto line = command_line(arguments);
  return parse_config(static_cast<int>(line.size()), line.data());
}

/// A file that is deleted with the test.
class TextFile {
 public:
  explicit TextFile(const std::string& text) {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-config-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    write(text);
  }
  ~TextFile() { std::filesystem::remove_all(folder_); }

  void write(const std::string& text) const { std::ofstream(path()) << text; }
  std::string path() const { return folder_ + "/file.toml"; }

 private:
  std::string folder_;
};

}  // namespace collided::server
