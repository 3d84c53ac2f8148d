#pragma once
// Shared by the mesh readers and writers: whole files in memory, words of a line, exact numbers.
//
// These readers exist because general importers round positions to float and merge or reorder vertices: here every
// vertex keeps its index and every position its exact double.

#include <charconv>
#include <concepts>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "client/scenes/mesh_files/mesh_file.hpp"

namespace collided::scenes {

[[noreturn]] inline void fail(const std::string& place, const std::string& what) {
  throw std::runtime_error(place + ": " + what);
}

template <std::invocable Place>
[[noreturn]] void fail(const Place& place, const std::string& what) {
  fail(place(), what);
}

std::string read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, const std::string& text);

/// Removes the next word (separated by blanks) from the front of `line`; empty at its end.
inline std::string_view next_word(std::string_view& line) {
  const size_t from = line.find_first_not_of(" \t\r");
  if (from == std::string_view::npos) return line = {};
  const size_t to = std::min(line.find_first_of(" \t\r", from), line.size());
  const std::string_view word = line.substr(from, to - from);
  line.remove_prefix(to);
  return word;
}

/// Removes the next line from the front of `text`, and returns it without its line break.
inline std::string_view next_line(std::string_view& text) {
  const size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

/// Of a number that std::from_chars finds out of range, whether it is too small for a double, not too large.
bool is_underflow(std::string_view word);

/// The number that `word` spells, rounded once, to T; 0 if it is closer to 0 than any other. `place`, or what it
/// returns, locates it in errors.
template <class T, class Place>
T parse_number(std::string_view word, const Place& place) {
  if (word.empty()) fail(place, "a number is missing");
  if (word.front() == '+') word.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::invalid_argument || end != word.data() + word.size())
    fail(place, "'" + std::string(word.substr(0, 40)) + "' is not a number");
  if (error == std::errc()) return value;
  if (std::floating_point<T> && is_underflow(word)) return 0;
  fail(place, "number " + std::string(word) + " is out of range");
}

/// Splits a polygon of corners into a fan of triangles.
void add_fan(const std::vector<uint32_t>& corners, MeshFile& mesh, const std::string& place);

MeshFile read_obj(std::string_view text, const std::string& file);
MeshFile read_ply(std::string_view text, const std::string& file);
std::string write_obj(const MeshFile& mesh);
std::string write_ply(const MeshFile& mesh);

}  // namespace collided::scenes
