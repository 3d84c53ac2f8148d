#pragma once
// The data folder with frames and queries labelled by others, which is not part of the repository.

#include <filesystem>
#include <optional>

namespace collided::test {

inline constexpr char kNoDataFolder[] = "the data folder is not here; set COLLIDED_DATA";

/// COLLIDED_DATA, or the folder `shared/data` next to the repository; nullopt if absent.
std::optional<std::filesystem::path> data_folder();

}  // namespace collided::test
