#pragma once
// Shared by the mesh readers and writers: whole files in memory, words of a line, exact numbers.
//
// These readers exist because general importers are not exact. Assimp 5.2 rounds positions to float, reads quantised
// glTF as garbage, drops faces with indices out of range without a word, and crashes or hangs on about 2 % of slightly
// damaged COLLADA files; trimesh 5.2 ignores sparse accessors and the scale of normalised positions. Here every
// position is the file's own, to the bit, and what cannot be read is refused.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/scenes/mesh_files/mesh_file.hpp"

namespace collided::scenes {

[[noreturn]] inline void fail(const std::string& place, const std::string& what) {
  throw std::runtime_error(place + ": " + what);
}

template <std::invocable Place>
[[noreturn]] void fail(const Place& place, const std::string& what) {
  fail(place(), what);
}

/// A word as messages show it, at most 40 bytes of it. A byte of 0 would end the message.
inline std::string shortened(std::string_view word) {
  std::string out;
  for (const char c : word.substr(0, 40)) c == '\0' ? out += "\xEF\xBF\xBD" : out += c;
  return out;
}
inline std::string in_quotes(std::string_view word) { return "'" + shortened(word) + "'"; }

std::string read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, const std::string& text);

/// Characters that separate the words of a line.
inline constexpr std::string_view kBlanks = " \t\r\v\f";
/// The byte order mark of UTF-8, which editors on Windows write.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

inline std::string_view without_mark(std::string_view text) {
  return text.substr(text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
}

/// Removes the next word (separated by blanks) from the front of `line`; empty at its end.
inline std::string_view next_word(std::string_view& line) {
  const size_t from = line.find_first_not_of(kBlanks);
  if (from == std::string_view::npos) return line = {};
  const size_t to = std::min(line.find_first_of(kBlanks, from), line.size());
  const std::string_view word = line.substr(from, to - from);
  line.remove_prefix(to);
  return word;
}

/// Removes the next line from the front of `text`, and returns it without its line break: LF, CR LF, or CR alone.
inline std::string_view next_line(std::string_view& text) {
  size_t end = 0;
  while (end < text.size() && text[end] != '\n' && text[end] != '\r') ++end;
  const std::string_view line = text.substr(0, end);
  end += text.substr(end, 2) == "\r\n" ? 2 : 1;
  text.remove_prefix(std::min(end, text.size()));
  return line;
}

/// Takes the words of a text in turn and counts its lines.
class Words {
 public:
  Words(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}
  /// Empty at the end of the text.
  std::string_view next() {
    for (;;) {
      const std::string_view word = next_word(line_);
      if (!word.empty() && word.front() != '#') return word;
      if (!next_line()) return {};
    }
  }
  /// Words up to the end of the line, without its comment.
  std::string_view rest_of_line() {
    const std::string_view rest = line_.substr(0, line_.find('#'));
    line_ = {};
    return rest;
  }
  /// The next line that has a word, without its comment; empty at the end of the text.
  std::string_view next_full_line() {
    for (;;) {
      const std::string_view rest = rest_of_line();
      if (rest.find_first_not_of(kBlanks) != std::string_view::npos) return rest;
      if (!next_line()) return {};
    }
  }
  size_t number() const { return number_; }  ///< of the line, from 1
  std::string place() const { return file_ + ":" + std::to_string(number_); }

 private:
  bool next_line() {
    if (text_.empty()) return false;
    line_ = scenes::next_line(text_);
    ++number_;
    return true;
  }

  std::string_view text_, line_;
  std::string file_;
  size_t number_ = 0;
};

/// Of a number that std::from_chars finds out of range, whether it is too small for a double, not too large.
bool is_underflow(std::string_view word);

/// The number that `word` spells, rounded once, to T; 0 if it is closer to 0 than any other, infinity if it is too large
/// for a floating-point T. `place`, or what it returns, locates it in errors.
template <class T, class Place>
T parse_number(std::string_view word, const Place& place) {
  if (word.empty()) fail(place, "a number is missing");
  const bool has_plus = word.front() == '+' && !word.starts_with("+-");  // from_chars takes no plus
  const std::string_view digits = word.substr(has_plus ? 1 : 0);
  T value{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  // from_chars takes a parenthesis behind "nan".
  if (error == std::errc::invalid_argument || end != digits.data() + digits.size() || word.ends_with(')'))
    fail(place, in_quotes(word) + " is not a number");
  if (error == std::errc()) return value;
  if constexpr (std::floating_point<T>) {
    if (is_underflow(digits)) return 0;
    return std::copysign(std::numeric_limits<T>::infinity(), word.starts_with('-') ? T{-1} : T{1});
  }
  fail(place, "number " + shortened(word) + " is out of range");
}

/// Parses a coordinate, which must be finite.
template <class Place>
double parse_coordinate(std::string_view word, const Place& place) {
  const auto value = parse_number<double>(word, place);
  if (std::isfinite(value)) return value;
  const bool is_spelled = word.find_first_of("nN") != std::string_view::npos;  // nan, inf or infinity
  fail(place, is_spelled ? "position " + shortened(word) + " is not finite"
                         : "number " + shortened(word) + " is out of range");
}

/// Divides a homogeneous position by its w.
template <class Place>
void divide_by_w(Vec3d& position, double w, const Place& place) {
  if (w == 0) fail(place, "w is 0: the vertex is at infinity");
  if (!std::isfinite(w)) fail(place, "w is not finite");
  if (w == 1) return;
  for (double& x : position) {
    x /= w;
    if (!std::isfinite(x)) fail(place, "the position divided by its w is not finite");
  }
}

/// "1 face", "2 faces". Plurals that end otherwise are given.
inline std::string count_text(uint64_t count, const std::string& noun, const std::string& plural = "") {
  return std::to_string(count) + " " + (count == 1 ? noun : plural.empty() ? noun + "s" : plural);
}

/// "there is 1 vertex", "there are 2 vertices".
inline std::string vertices_there(uint64_t count) {
  return (count == 1 ? "there is " : "there are ") + count_text(count, "vertex", "vertices");
}

/// Faces, edges and points as a reader found them, before anything is checked.
struct RawMesh {
  std::vector<Vec3d> positions;
  Polygons polygons;
  std::vector<uint32_t> lines;  ///< of the file, for each polygon; none if the format has no lines
  std::vector<std::array<uint32_t, 2>> edges;
  std::vector<uint32_t> points;
  std::vector<std::string> notes;

  void add_face(std::initializer_list<uint32_t> corners) { add_face(corners.begin(), corners.size()); }
  void add_face(const uint32_t* corners, size_t count) {
    polygons.corners.insert(polygons.corners.end(), corners, corners + count);
    polygons.counts.push_back(static_cast<uint32_t>(count));
  }
  void add_strip(const std::vector<uint32_t>& strip) {
    for (size_t i = 2; i < strip.size(); ++i)
      if (i % 2 == 0)
        add_face({strip[i - 2], strip[i - 1], strip[i]});
      else
        add_face({strip[i - 1], strip[i - 2], strip[i]});
  }
  void add_fan(const std::vector<uint32_t>& fan) {
    for (size_t i = 2; i < fan.size(); ++i) add_face({fan[0], fan[i - 1], fan[i]});
  }
  /// Vertices, corners of faces, ends of edges, and points.
  uint64_t size() const {
    return positions.size() + polygons.corners.size() + 2 * edges.size() + points.size();
  }
  /// Adds positions and elements of a mesh without lines.
  void append(const RawMesh& part) {
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), part.positions.begin(), part.positions.end());
    polygons.counts.insert(polygons.counts.end(), part.polygons.counts.begin(), part.polygons.counts.end());
    for (const uint32_t corner : part.polygons.corners) polygons.corners.push_back(first + corner);
    for (const auto& [a, b] : part.edges) edges.push_back({first + a, first + b});
    for (const uint32_t point : part.points) points.push_back(first + point);
  }
};

/// Merges equal positions from the vertex `first` on, which corners of the polygons from `first_corner` on, and edges
/// and points from the given ones on, name. Returns how many vertices went away.
size_t weld(RawMesh& mesh, size_t first = 0, size_t first_corner = 0, size_t first_edge = 0, size_t first_point = 0);

RawMesh read_obj(std::string_view text, const std::string& file);
RawMesh read_ply(std::string_view text, const std::string& file);
RawMesh read_stl(std::string_view text, const std::string& file);
RawMesh read_off(std::string_view text, const std::string& file);
/// Also GLB. `file`: buffers in files of their own are read from its folder.
RawMesh read_gltf(std::string_view text, const std::string& file);
RawMesh read_dae(std::string_view text, const std::string& file);
/// Reads a text of the format with this extension, in lower case, and splits its faces.
MeshFile parse_mesh(const std::string& extension, std::string_view text, const std::string& file,
                    const MeshFile* like = nullptr);
std::string write_obj(const MeshFile& mesh);
std::string write_ply(const MeshFile& mesh);

}  // namespace collided::scenes
