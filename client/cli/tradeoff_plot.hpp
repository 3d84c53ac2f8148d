#pragma once
// Tradeoffs as one picture: a row of panels each.

#include <filesystem>
#include <span>

#include "client/measure/tradeoff/result.hpp"

namespace collided::cli {

/// Draws to two files. Throws std::runtime_error if one cannot be written.
void plot_tradeoffs(std::span<const Tradeoff> results, const std::filesystem::path& svg,
                    const std::filesystem::path& png);

}  // namespace collided::cli
