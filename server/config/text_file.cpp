// Small files that options name.
#include "server/config/text_file.hpp"

#include <filesystem>
#include <fstream>

#include "server/config/config.hpp"

namespace collided::server {

std::string read_text_file(const std::string& path, uint64_t max_bytes) {
  std::error_code error;
  // Devices and pipes could go on for ever, or make the daemon wait.
  if (!std::filesystem::is_regular_file(path, error)) throw ConfigError(path + ": is not a file that can be read");
  std::ifstream file(path, std::ios::binary);
  std::string text(max_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file && !file.eof()) throw ConfigError(path + ": cannot be read");
  text.resize(static_cast<size_t>(file.gcount()));
  if (text.size() > max_bytes) throw ConfigError(path + ": has more than " + std::to_string(max_bytes) + " bytes");
  return text;
}

}  // namespace collided::server
