// OBJ: lines "v x y z", "f a b c ...", "l a b ..." and "p a ..." (also a/b/c, and negative indices, which count back);
// others are skipped, and comments behind '#'. A line that ends in '\' goes on in the next one.

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

/// Three coordinates; a fourth number alone is a weight w, three or four more are a colour.
Vec3d parse_vertex(std::string_view line, const std::string& place) {
  Vec3d p;
  for (double& x : p) x = parse_coordinate(next_word(line), place);
  const std::string_view fourth = next_word(line);
  if (fourth.empty()) return p;
  size_t numbers = 4;
  while (!next_word(line).empty()) ++numbers;
  if (numbers == 4) divide_by_w(p, parse_number<double>(fourth, place), place);
  if (numbers == 5 || numbers > 7)
    fail(place, "the vertex has " + std::to_string(numbers) +
                    " numbers; it needs 3, 4 with a weight, or 6 or 7 with a colour");
  return p;
}

/// The largest vertex index of all elements and its line: elements may come before their vertices.
struct MaxCorner {
  uint32_t corner = 0;
  size_t line = 0;

  void include(const std::vector<uint32_t>& corners, size_t number) {
    for (const uint32_t c : corners)
      if (line == 0 || c > corner) *this = {c, number};
  }
};

uint32_t parse_corner(std::string_view word, size_t vertices, const std::string& place) {
  const auto index = parse_number<int64_t>(word.substr(0, word.find('/')), place);
  const int64_t from_zero = index < 0 ? static_cast<int64_t>(vertices) + index : index - 1;
  if (index == 0 || from_zero < 0 || from_zero > int64_t{UINT32_MAX})
    fail(place, "vertex index " + std::to_string(index) + " is out of range");
  return static_cast<uint32_t>(from_zero);
}

/// A line of several vertices is as many edges, less one.
void add_line(const std::vector<uint32_t>& vertices, RawMesh& mesh, const std::string& place) {
  if (vertices.size() < 2)
    fail(place, "the line has " + count_text(vertices.size(), "vertex", "vertices") + "; it needs 2");
  for (size_t i = 1; i < vertices.size(); ++i) mesh.edges.push_back({vertices[i - 1], vertices[i]});
}

void add_element(std::string_view key, const std::vector<uint32_t>& vertices, RawMesh& mesh, size_t line,
                 const std::string& place) {
  if (key == "l") return add_line(vertices, mesh, place);
  if (key == "p") {
    mesh.points.insert(mesh.points.end(), vertices.begin(), vertices.end());
    return;
  }
  mesh.add_face(vertices.data(), vertices.size());
  mesh.lines.push_back(static_cast<uint32_t>(line));
}

class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : text_(text) {}

  bool has_next() const { return !text_.empty(); }
  /// Without its comment, whose end is no '\': it would take the next line with it. Valid until the next call.
  std::string_view next() {
    number_ = read_ + 1;
    std::string_view line = read();
    if (!line.ends_with('\\')) return line;
    joined_.clear();
    for (; line.ends_with('\\'); line = read()) (joined_ += line.substr(0, line.size() - 1)) += ' ';
    return joined_ += line;
  }
  /// Of the first of the lines that next() has joined, from 1.
  size_t number() const { return number_; }

 private:
  std::string_view read() {
    ++read_;
    const std::string_view line = next_line(text_);
    return line.substr(0, line.find('#'));
  }

  std::string_view text_;
  std::string joined_;
  size_t read_ = 0, number_ = 0;
};

void append_number(std::string& out, double x) {
  char buffer[40];
  out.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, x, std::chars_format::general, 17).ptr);
}

}  // namespace

RawMesh read_obj(std::string_view text, const std::string& file) {
  text = without_mark(text);
  RawMesh mesh;
  std::vector<uint32_t> corners;
  MaxCorner max;
  for (ObjLines lines(text); lines.has_next();) {
    std::string_view line = lines.next();
    const std::string_view key = next_word(line);
    if (key != "v" && key != "f" && key != "l" && key != "p") continue;
    const std::string place = file + ":" + std::to_string(lines.number());
    if (key == "v") {
      mesh.positions.push_back(parse_vertex(line, place));
      continue;
    }
    corners.clear();
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
      corners.push_back(parse_corner(word, mesh.positions.size(), place));
    add_element(key, corners, mesh, lines.number(), place);
    max.include(corners, lines.number());
  }
  if (max.line > 0 && max.corner >= mesh.positions.size())
    fail(file + ":" + std::to_string(max.line), "vertex index " + std::to_string(uint64_t{max.corner} + 1) +
                                                    " is out of range; " + vertices_there(mesh.positions.size()));
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
