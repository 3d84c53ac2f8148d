// OBJ: lines "v x y z" and "f a b c ..." (also a/b/c, and negative indices that count back); the rest is passed over.

#include "client/scenes/mesh_text.hpp"

namespace collided::scenes {

namespace {

Vec3d parse_vertex(std::string_view line, const std::string& place) {
  Vec3d p;
  for (double& x : p) x = parse_number<double>(next_word(line), place);
  return p;
}

uint32_t parse_corner(std::string_view word, size_t vertices, const std::string& place) {
  const auto index = parse_number<int64_t>(word.substr(0, word.find('/')), place);
  const int64_t from_zero = index < 0 ? static_cast<int64_t>(vertices) + index : index - 1;
  if (index == 0 || from_zero < 0 || from_zero > int64_t{UINT32_MAX})
    fail(place, "vertex index " + std::to_string(index) + " is out of range");
  return static_cast<uint32_t>(from_zero);
}

void append_number(std::string& out, double x) {
  char buffer[40];
  out.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, x, std::chars_format::general, 17).ptr);
}

}  // namespace

MeshFile read_obj(std::string_view text, const std::string& file) {
  MeshFile mesh;
  std::vector<uint32_t> corners;
  for (size_t number = 1; !text.empty(); ++number) {
    std::string_view line = next_line(text);
    const std::string_view key = next_word(line);
    if (key != "v" && key != "f") continue;
    const std::string place = file + ":" + std::to_string(number);
    if (key == "v") {
      mesh.positions.push_back(parse_vertex(line, place));
      continue;
    }
    corners.clear();
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
      corners.push_back(parse_corner(word, mesh.positions.size(), place));
    add_fan(corners, mesh, place);
  }
  return mesh;
}

std::string write_obj(const MeshFile& mesh) {
  std::string out;
  for (const Vec3d& p : mesh.positions) {
    out += 'v';
    for (const double x : p) append_number(out += ' ', x);
    out += '\n';
  }
  for (const auto& t : mesh.triangles) {
    out += 'f';
    for (const uint32_t v : t) out += ' ' + std::to_string(uint64_t{v} + 1);
    out += '\n';
  }
  return out;
}

}  // namespace collided::scenes
