#pragma once
// Files that are there whole or not at all, also after a crash.

#include <filesystem>

namespace collided::cli {

/// Gives a file its name, and returns once this is on the disk. Its content must be there already. Throws
/// std::runtime_error naming the file.
void rename_durably(const std::filesystem::path& from, const std::filesystem::path& to);

/// The same with the content: of a file that was written and closed.
void sync_and_rename(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace collided::cli
