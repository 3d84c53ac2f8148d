// Writes an image as PNG.

#include "client/cli/picture/png.hpp"

#include <png.h>

#include <stdexcept>

#include "client/app/output/output.hpp"

namespace collided::cli {

void write_png(const std::string& file, const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string text(bytes, '\0');
  if (png_image_write_to_memory(&png, text.data(), &bytes, 0, image.pixels.data(), 0, nullptr) == 0)
    throw std::runtime_error(file + ": cannot be encoded: " + png.message);
  text.resize(bytes);
  write_text(file, text);
}

}  // namespace collided::cli
