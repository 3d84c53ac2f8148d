// Reads PLY: positions of "vertex", corners of "face" and strips of "tristrips"; other elements and properties are
// skipped.

#include <algorithm>
#include <array>
#include <bit>

#include "client/scenes/mesh_files/mesh_text.hpp"
#include "client/scenes/mesh_files/ply_header.hpp"

namespace collided::scenes {

namespace {

/// A number as messages show it.
std::string text_of(double number) {
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

/// The line breaks in a text that is not cut within one.
size_t count_lines(std::string_view text) {
  size_t lines = 0;
  for (size_t i = 0; i < text.size(); ++i)
    lines += text[i] == '\n' || (text[i] == '\r' && text.substr(i + 1, 1) != "\n");
  return lines;
}

/// Reads numbers from the body, whatever their encoding. A double holds every PLY type exactly.
class Body {
 public:
  /// `text` begins on line `line` of the file.
  Body(std::string_view text, size_t line, PlyFormat format, std::string file)
      : text_(text), line_(line), format_(format), file_(std::move(file)) {}

  /// The element that the next numbers belong to, for messages.
  void begin(const std::string& element) { element_ = element; }

  double number(PlyType type) {
    if (format_ == PlyFormat::kAscii) return ascii_number();
    switch (type) {
      case PlyType::kInt8:
        return binary<int8_t, uint8_t>();
      case PlyType::kUint8:
        return binary<uint8_t, uint8_t>();
      case PlyType::kInt16:
        return binary<int16_t, uint16_t>();
      case PlyType::kUint16:
        return binary<uint16_t, uint16_t>();
      case PlyType::kInt32:
        return binary<int32_t, uint32_t>();
      case PlyType::kUint32:
        return binary<uint32_t, uint32_t>();
      case PlyType::kFloat:
        return binary<float, uint32_t>();
      case PlyType::kDouble:
        break;
    }
    return binary<double, uint64_t>();
  }

  uint64_t list_length(const PlyProperty& property, const std::string& place) {
    const double length = number(property.count_type);
    if (length != std::floor(length)) fail(place, "a list's length " + text_of(length) + " is not an integer");
    if (length < 0) fail(place, "a list of " + text_of(length) + " does not fit in the file");
    if (length > static_cast<double>(text_.size())) fail_cut_off();
    return static_cast<uint64_t>(length);
  }

  /// Says what follows the last element, if something does.
  void add_note(std::vector<std::string>& notes) {
    if (format_ != PlyFormat::kAscii) {
      if (!text_.empty()) notes.push_back("ignored " + count_text(text_.size(), "byte") + " after the last element");
      return;
    }
    uint64_t words = 0;
    while (!next_word().empty()) ++words;
    if (words > 0) notes.push_back("ignored " + count_text(words, "word") + " after the last element");
  }

 private:
  [[noreturn]] void fail_cut_off() const { fail(file_, "is cut off within element " + element_); }

  /// Takes a word of ascii text; empty at its end.
  std::string_view next_word() {
    static constexpr std::string_view kSpaces = " \t\r\n\v\f";
    const size_t from = std::min(text_.find_first_not_of(kSpaces), text_.size());
    const size_t to = std::min(text_.find_first_of(kSpaces, from), text_.size());
    const std::string_view word = text_.substr(from, to - from);
    line_ += count_lines(text_.substr(0, from));
    text_.remove_prefix(to);
    return word;
  }

  /// Decimal text is read at double precision, whatever type the header names, so that nothing is rounded twice.
  double ascii_number() {
    const std::string_view word = next_word();
    if (word.empty()) fail_cut_off();
    return parse_number<double>(word, [this] { return file_ + ":" + std::to_string(line_); });
  }

  template <class T, class Bits>
  double binary() {
    if (text_.size() < sizeof(Bits)) fail_cut_off();
    Bits bits = 0;
    for (size_t i = 0; i < sizeof(Bits); ++i) {
      const size_t shift = 8 * (format_ == PlyFormat::kLittleEndian ? i : sizeof(Bits) - 1 - i);
      bits = static_cast<Bits>(bits | static_cast<Bits>(Bits{static_cast<unsigned char>(text_[i])} << shift));
    }
    text_.remove_prefix(sizeof(Bits));
    return static_cast<double>(std::bit_cast<T>(bits));
  }

  std::string_view text_;
  size_t line_;  ///< of ascii text
  PlyFormat format_;
  std::string file_, element_;
};

void skip(Body& body, const PlyProperty& property, const std::string& place) {
  const uint64_t n = property.is_list ? body.list_length(property, place) : 1;
  for (uint64_t i = 0; i < n; ++i) body.number(property.type);
}

void read_vertices(Body& body, const PlyElement& element, RawMesh& mesh, const std::string& file) {
  std::vector<int> axis_of;
  int found = 0;
  for (const PlyProperty& p : element.properties) {
    const bool is_axis = !p.is_list && p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z';
    axis_of.push_back(is_axis ? p.name[0] - 'x' : -1);
    if (is_axis) found |= 1 << axis_of.back();
  }
  if (found != 7) fail(file, "element vertex lacks one of the properties x, y, z");
  mesh.positions.resize(element.count);
  for (uint64_t v = 0; v < element.count; ++v)
    for (size_t i = 0; i < axis_of.size(); ++i) {
      if (axis_of[i] < 0)
        skip(body, element.properties[i], file + ": vertex " + std::to_string(v));
      else
        mesh.positions[v][static_cast<size_t>(axis_of[i])] = body.number(element.properties[i].type);
    }
}

/// An index below 0 restarts a strip.
constexpr uint32_t kRestart = UINT32_MAX;

uint32_t read_index(Body& body, PlyType type, bool can_restart, const std::string& place) {
  const double index = body.number(type);
  if (index != std::floor(index)) fail(place, "vertex index " + text_of(index) + " is not an integer");
  if (can_restart && index < 0) return kRestart;
  if (!(index >= 0 && index < kRestart)) fail(place, "vertex index " + text_of(index) + " is out of range");
  return static_cast<uint32_t>(index);
}

/// The corners of a face, or the strips of an element.
std::vector<uint32_t> read_corners(Body& body, const PlyElement& element, const std::string& place) {
  std::vector<uint32_t> corners;
  for (const PlyProperty& p : element.properties) {
    if (!is_corners(p)) {
      skip(body, p, place);
      continue;
    }
    for (uint64_t n = body.list_length(p, place); n > 0; --n)
      corners.push_back(read_index(body, p.type, element.name == "tristrips", place));
  }
  return corners;
}

void add_strips(const std::vector<uint32_t>& indices, RawMesh& mesh) {
  std::vector<uint32_t> strip;
  for (const uint32_t index : indices) {
    if (index != kRestart) {
      strip.push_back(index);
      continue;
    }
    mesh.add_strip(strip);
    strip.clear();
  }
  mesh.add_strip(strip);
}

}  // namespace

RawMesh read_ply(std::string_view text, const std::string& file) {
  const std::string_view whole = text;
  const PlyHeader header = read_ply_header(text, file);
  Body body(text, 1 + count_lines(whole.substr(0, whole.size() - text.size())), header.format, file);
  RawMesh mesh;
  for (const PlyElement& element : header.elements) {
    body.begin(element.name);
    if (element.name == "edge" && element.count > 0) mesh.notes.push_back("ignored " + count_text(element.count, "edge"));
    if (element.name == "vertex") {
      read_vertices(body, element, mesh, file);
      continue;
    }
    for (uint64_t i = 0; i < element.count; ++i) {
      const std::string place = file + ": " + element.name + " " + std::to_string(i);
      if (element.name == "face") {
        const std::vector<uint32_t> corners = read_corners(body, element, place);
        mesh.add_face(corners.data(), corners.size());
      } else if (element.name == "tristrips") {
        add_strips(read_corners(body, element, place), mesh);
      } else {
        for (const PlyProperty& p : element.properties) skip(body, p, place);
      }
    }
  }
  body.add_note(mesh.notes);
  return mesh;
}

}  // namespace collided::scenes
