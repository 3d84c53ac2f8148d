#pragma once
// Writes an image as PNG.

#include <cstdint>
#include <string>
#include <vector>

namespace collided::cli {

struct Image {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> pixels = {};  ///< red, green, blue, row by row from the top
};

/// Throws std::runtime_error naming the file.
void write_png(const std::string& file, const Image& image);

}  // namespace collided::cli
