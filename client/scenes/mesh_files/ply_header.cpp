// The header of a PLY file: its format, its elements and their properties.

#include "client/scenes/mesh_files/ply_header.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

PlyType parse_type(std::string_view word, const std::string& place) {
  constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{{{"char", PlyType::kInt8},
                                                                         {"int8", PlyType::kInt8},
                                                                         {"uchar", PlyType::kUint8},
                                                                         {"uint8", PlyType::kUint8},
                                                                         {"short", PlyType::kInt16},
                                                                         {"int16", PlyType::kInt16},
                                                                         {"ushort", PlyType::kUint16},
                                                                         {"uint16", PlyType::kUint16},
                                                                         {"int", PlyType::kInt32},
                                                                         {"int32", PlyType::kInt32},
                                                                         {"uint", PlyType::kUint32},
                                                                         {"uint32", PlyType::kUint32},
                                                                         {"float", PlyType::kFloat},
                                                                         {"float32", PlyType::kFloat},
                                                                         {"double", PlyType::kDouble},
                                                                         {"float64", PlyType::kDouble}}};
  for (const auto& [name, type] : kTypes)
    if (name == word) return type;
  fail(place, "type " + in_quotes(word) + " is not a PLY type");
}

PlyFormat parse_format(std::string_view word, const std::string& place) {
  if (word == "ascii") return PlyFormat::kAscii;
  if (word == "binary_little_endian") return PlyFormat::kLittleEndian;
  if (word == "binary_big_endian") return PlyFormat::kBigEndian;
  fail(place, "format " + in_quotes(word) + " is not a PLY format");
}

/// True for elements whose lists of vertices are read.
bool has_corners(const PlyElement& element) { return element.name == "face" || element.name == "tristrips"; }

PlyProperty parse_property(std::string_view line, const PlyElement& element, const std::string& place) {
  PlyProperty property;
  std::string_view word = next_word(line);
  if (word == "list") {
    property.is_list = true;
    property.count_type = parse_type(next_word(line), place);
    if (property.count_type >= PlyType::kFloat) fail(place, "a list's length must be an integer type");
    word = next_word(line);
  }
  property.type = parse_type(word, place);
  property.name = next_word(line);
  if (property.name.empty()) fail(place, "the property has no name");
  if (!has_corners(element) || !is_corners(property)) return property;
  if (property.type >= PlyType::kFloat) fail(place, property.name + " must be of an integer type");
  if (std::any_of(element.properties.begin(), element.properties.end(), is_corners))
    fail(place, "element " + element.name + " has two lists of vertices");
  return property;
}

void add_property(std::string_view line, PlyElement& element, const std::string& place) {
  const PlyProperty property = parse_property(line, element, place);
  for (const PlyProperty& known : element.properties)
    if (known.name == property.name)
      fail(place, "element " + element.name + " has the property " + in_quotes(property.name) + " twice");
  element.properties.push_back(property);
}

void add_element(std::string_view line, PlyHeader& header, const std::string& place) {
  const std::string name(next_word(line));
  for (const PlyElement& known : header.elements)
    if (known.name == name) fail(place, "the header has the element " + in_quotes(name) + " twice");
  header.elements.push_back({name, parse_number<uint64_t>(next_word(line), place), {}});
}

/// The minimum size of one element in the file.
uint64_t min_bytes(const PlyElement& element, PlyFormat format) {
  uint64_t bytes = 0;
  for (const PlyProperty& p : element.properties)
    bytes += format == PlyFormat::kAscii ? 1 : size_of(p.is_list ? p.count_type : p.type);
  return bytes;
}

void check_counts(const PlyHeader& header, uint64_t left, const std::string& file) {
  for (const PlyElement& element : header.elements) {
    const uint64_t each = min_bytes(element, header.format);
    if (element.count == 0) continue;
    if (each == 0) fail(file, "element " + element.name + " has no properties");
    if (element.count > left / each)
      fail(file, "is cut off: " + std::to_string(element.count) + " of element " + element.name +
                     " do not fit in the " + std::to_string(left) + " bytes that follow the header");
  }
}

}  // namespace

uint32_t size_of(PlyType type) {
  constexpr std::array<uint32_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<size_t>(type)];
}

PlyHeader read_ply_header(std::string_view& text, const std::string& file) {
  text = without_mark(text);
  // After a line that CR alone ends, an LF is the first byte of binary data.
  const bool has_cr_lines = text.starts_with("ply\r") && !text.starts_with("ply\r\n");
  if (next_line(text) != "ply") fail(file, "does not begin with 'ply'");
  PlyHeader header;
  bool has_format = false;
  for (size_t number = 2;; ++number) {
    if (text.empty()) fail(file, "is cut off in its header");
    const std::string place = file + ":" + std::to_string(number);
    const std::string_view from_line = text;
    std::string_view line = next_line(text);
    const size_t length = line.size();
    const std::string_view key = next_word(line);
    if (key == "end_header") {
      if (has_cr_lines) text = from_line.substr(std::min(length + 1, from_line.size()));
      break;
    }
    if (key == "format") {
      header.format = parse_format(next_word(line), place);
      has_format = true;
    } else if (key == "element") {
      add_element(line, header, place);
    } else if (key == "property") {
      if (header.elements.empty()) fail(place, "a property stands before any element");
      add_property(line, header.elements.back(), place);
    } else if (key != "comment" && key != "obj_info" && !key.empty()) {
      fail(place, in_quotes(key) + " is not a PLY keyword");
    }
  }
  if (!has_format) fail(file, "has no format line");
  for (const PlyElement& element : header.elements)
    if (has_corners(element) && element.count > 0 &&
        std::none_of(element.properties.begin(), element.properties.end(), is_corners))
      fail(file, "element " + element.name + " lacks the list vertex_indices");
  check_counts(header, text.size(), file);
  return header;
}

}  // namespace collided::scenes
