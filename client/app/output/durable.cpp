// Files that are there whole or not at all.

#include "client/app/output/durable.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace collided::cli {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
  throw std::runtime_error(file.string() + ": cannot be written: " + std::strerror(error));
}

int sync(const std::filesystem::path& path, int flags) {
  const int opened = open(path.c_str(), flags | O_CLOEXEC);
  if (opened < 0) return errno;
  const int error = fsync(opened) == 0 ? 0 : errno;
  close(opened);
  return error;
}

}  // namespace

void rename_durably(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) fail(to, errno);
  const auto folder = to.has_parent_path() ? to.parent_path() : std::filesystem::path(".");
  const int error = sync(folder, O_RDONLY | O_DIRECTORY);
  if (error != 0 && error != EINVAL) fail(to, error);  // EINVAL: this file system has no such thing
}

void sync_and_rename(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (const int error = sync(from, O_RDONLY)) fail(from, error);
  rename_durably(from, to);
}

}  // namespace collided::cli
