// OFF: a keyword with prefixes (ST, C, N, 4), three counts, a vertex a line, a face a line; '#' begins a comment.
// Normals, colours and texture coordinates are skipped.

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

constexpr std::string_view kDigits = "0123456789";

/// Reads the keyword's prefixes; returns whether vertices have a w.
bool read_keyword(std::string_view word, const std::string& file) {
  std::string_view prefix = word.substr(0, word.size() - 3);
  const auto take = [&](std::string_view known) {
    const bool is_there = prefix.starts_with(known);
    if (is_there) prefix.remove_prefix(known.size());
    return is_there;
  };
  take("ST"), take("C"), take("N");
  const bool has_w = take("4");
  if (!prefix.empty()) fail(file, in_quotes(word) + " is a kind of OFF that is not read");
  return has_w;
}

void check_count(uint64_t count, uint64_t each, const std::string& what, uint64_t left, const std::string& file) {
  if (count > left / each)
    fail(file, "is cut off: " + std::to_string(count) + " " + what + " do not fit in the " + std::to_string(left) +
                   " bytes of the file");
}

Vec3d parse_vertex(std::string_view line, bool has_w, const std::string& place) {
  Vec3d p;
  for (double& x : p) x = parse_coordinate(next_word(line), place);
  if (has_w) divide_by_w(p, parse_number<double>(next_word(line), place), place);
  return p;
}

void add_face(std::string_view line, RawMesh& mesh, const std::string& place) {
  const auto count = parse_number<uint64_t>(next_word(line), place);
  std::vector<uint32_t> corners;
  for (uint64_t i = 0; i < count; ++i) corners.push_back(parse_number<uint32_t>(next_word(line), place));
  mesh.add_face(corners.data(), corners.size());
}

}  // namespace

RawMesh read_off(std::string_view text, const std::string& file) {
  text = without_mark(text);
  Words words(text, file);
  std::string_view line = words.next_full_line(), rest = line;
  const std::string_view keyword = next_word(rest);
  bool has_w = false;
  if (keyword.ends_with("OFF")) {
    has_w = read_keyword(keyword, file);
    std::string_view more = rest;
    const std::string_view next = next_word(more);
    if (next == "BINARY") fail(file, "binary OFF is not read");
    line = next.empty() ? words.next_full_line() : rest;
  } else if (keyword.empty() || kDigits.find(keyword.front()) == std::string_view::npos) {
    fail(file, "does not begin with 'OFF'");
  }
  const auto vertices = parse_number<uint64_t>(next_word(line), words.place());
  const auto faces = parse_number<uint64_t>(next_word(line), words.place());
  next_word(line);  // the number of edges
  if (!next_word(line).empty())
    fail(words.place(), "more than three counts are in this line; each vertex and face must have a line of its own");
  check_count(vertices, 5, "vertices", text.size(), file);
  check_count(faces, 5, "faces", text.size(), file);
  RawMesh mesh;
  for (uint64_t v = 0; v < vertices; ++v) {
    const std::string_view vertex = words.next_full_line();
    if (vertex.empty())
      fail(file, "is cut off: vertex " + std::to_string(v) + " of " + std::to_string(vertices) + " is missing");
    mesh.positions.push_back(parse_vertex(vertex, has_w, words.place()));
  }
  for (uint64_t f = 0; f < faces; ++f) {
    const std::string_view face = words.next_full_line();
    if (face.empty())
      fail(file, "is cut off: face " + std::to_string(f) + " of " + std::to_string(faces) + " is missing");
    add_face(face, mesh, words.place());
    mesh.lines.push_back(static_cast<uint32_t>(words.number()));
  }
  uint64_t ignored = 0;
  while (!words.next_full_line().empty()) ++ignored;
  if (ignored > 0) mesh.notes.push_back("ignored " + count_text(ignored, "line") + " after the last face");
  return mesh;
}

}  // namespace collided::scenes
