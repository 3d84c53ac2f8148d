#pragma once
// Files that only the daemon should be able to read.

#include <spdlog/common.h>

#include <filesystem>
#include <string>

#include "server/ops/log.hpp"

namespace collided::server {

/// Logs a warning if every user of this host can read the file.
inline void warn_if_others_can_read(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!error && (status.permissions() & std::filesystem::perms::others_read) != std::filesystem::perms::none)
    log_event(spdlog::level::warn, "every user of this host can read the secrets of a file", {{"file", path}});
}

}  // namespace collided::server
