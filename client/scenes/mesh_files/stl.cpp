// STL, ASCII (of one or more solids) or binary. Each facet brings its own corners: equal ones are welded into one
// vertex.

#include <algorithm>
#include <bit>
#include <cstring>

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

constexpr size_t kHeaderBytes = 84, kFacetBytes = 50;

uint32_t little_endian(const char* bytes) {
  uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value |= uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  return value;
}

bool equal_words(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == y; });
}

/// Binary files may begin with "solid" as well.
bool is_binary(std::string_view text) {
  if (text.size() >= kHeaderBytes && text.size() == kHeaderBytes + kFacetBytes * uint64_t{little_endian(&text[80])})
    return true;
  std::string_view head = without_mark(text.substr(0, 512));
  head.remove_prefix(std::min(head.find_first_not_of(" \t\r\n\v\f"), head.size()));
  return !equal_words(head.substr(0, 5), "solid") || head.find('\0') != std::string_view::npos;
}

void add_corner(RawMesh& mesh, const Vec3d& position) {
  mesh.polygons.corners.push_back(static_cast<uint32_t>(mesh.positions.size()));
  mesh.positions.push_back(position);
}

RawMesh read_binary(std::string_view text, const std::string& file) {
  if (text.size() < kHeaderBytes)
    fail(file, "is cut off, or no STL: it has " + count_text(text.size(), "byte") + "; the header alone has 84");
  const uint64_t facets = little_endian(&text[80]), bytes = kHeaderBytes + kFacetBytes * facets;
  if (text.size() < bytes)
    fail(file, "is cut off, or no STL: its " + count_text(facets, "facet") + " need " + std::to_string(bytes) +
                   " bytes; it has " + std::to_string(text.size()));
  RawMesh mesh;
  for (uint64_t facet = 0; facet < facets; ++facet) {
    const char* const corners = &text[kHeaderBytes + kFacetBytes * facet + 12];
    for (int corner = 0; corner < 3; ++corner) {
      Vec3d p;
      for (int axis = 0; axis < 3; ++axis)
        p[static_cast<size_t>(axis)] = std::bit_cast<float>(little_endian(corners + 12 * corner + 4 * axis));
      if (!std::isfinite(p[0] + p[1] + p[2]))
        fail(file + ": facet " + std::to_string(facet), "a position is not finite");
      add_corner(mesh, p);
    }
    mesh.polygons.counts.push_back(3);
  }
  if (text.size() > bytes)
    mesh.notes.push_back("ignored " + count_text(text.size() - bytes, "byte") + " after the last facet");
  return mesh;
}

class AsciiReader {
 public:
  AsciiReader(std::string_view text, const std::string& file) : words_(text, file), file_(file) {}

  RawMesh run() {
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next())
      if (equal_words(word, "facet"))
        read_facet();
      else if (equal_words(word, "solid") || equal_words(word, "endsolid"))
        is_open_ = equal_words(word, "solid"), words_.rest_of_line();  // the name
      else
        fail(words_.place(), in_quotes(word) + " is not an STL keyword");
    if (is_open_) fail(file_, "is cut off: 'endsolid' is missing");
    return std::move(mesh_);
  }

 private:
  void expect(std::string_view keyword) {
    const std::string_view word = words_.next();
    if (word.empty()) fail(file_, "is cut off: " + in_quotes(keyword) + " is missing");
    if (!equal_words(word, keyword))
      fail(words_.place(),
           in_quotes(word) + " stands where " + in_quotes(keyword) + " must");
  }

  void read_facet() {
    expect("normal");
    for (int i = 0; i < 3; ++i) words_.next();
    expect("outer"), expect("loop");
    mesh_.lines.push_back(static_cast<uint32_t>(words_.number()));
    uint32_t corners = 0;
    for (std::string_view word = words_.next(); !equal_words(word, "endloop"); word = words_.next(), ++corners) {
      if (word.empty()) fail(file_, "is cut off: 'endloop' is missing");
      if (!equal_words(word, "vertex"))
        fail(words_.place(), in_quotes(word) + " stands where 'vertex' or 'endloop' must");
      Vec3d p;
      for (double& x : p) x = parse_coordinate(words_.next(), [&] { return words_.place(); });
      add_corner(mesh_, p);
    }
    mesh_.polygons.counts.push_back(corners);
    expect("endfacet");
  }

  Words words_;
  const std::string& file_;
  RawMesh mesh_;
  bool is_open_ = false;
};

}  // namespace

RawMesh read_stl(std::string_view text, const std::string& file) {
  RawMesh mesh = is_binary(text) ? read_binary(text, file) : AsciiReader(without_mark(text), file).run();
  const size_t corners = mesh.positions.size();
  if (weld(mesh) > 0)
    mesh.notes.push_back("welded " + count_text(corners, "corner") + " into " +
                         count_text(mesh.positions.size(), "vertex", "vertices"));
  return mesh;
}

}  // namespace collided::scenes
