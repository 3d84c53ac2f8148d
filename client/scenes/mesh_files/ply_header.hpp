#pragma once
// The header of a PLY file: its format, its elements and their properties.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace collided::scenes {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };

uint32_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< of a list's length
};

/// Whether a property of a face lists its vertices.
inline bool is_corners(const PlyProperty& p) {
  return p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index");
}

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
};

/// Removes the header from the front of `text`. Checks counts against the bytes that follow, so that a hostile header
/// cannot make the reader allocate memory.
PlyHeader read_ply_header(std::string_view& text, const std::string& file);

}  // namespace collided::scenes
