// Frames in mesh files, one a file.

#include "client/app/input/frame_files.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <tuple>
#include <utility>

#include "client/scenes/mesh_files/mesh_file.hpp"

namespace collided::cli {

namespace {

[[noreturn]] void differ(const std::string& how) {
  throw std::runtime_error("the frames differ: " + how + "; two meshes go without --frames: 'collidectl detect A B'");
}

void check_same(const char* what, const std::string& first_file, size_t first, const std::string& file, size_t other) {
  if (first != other)
    differ(first_file + " has " + std::to_string(first) + " " + what + ", " + file + " has " + std::to_string(other));
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Removes the leading characters that are digits, or are not, and returns them.
std::string_view take_run(std::string_view& text, bool digits) {
  const auto end = std::find_if(text.begin(), text.end(), [&](char c) { return is_digit(c) != digits; });
  const std::string_view run = text.substr(0, static_cast<size_t>(end - text.begin()));
  text.remove_prefix(run.size());
  return run;
}

/// Orders runs of digits, of any length, by their value.
std::pair<size_t, std::string_view> value_of(std::string_view digits) {
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return {digits.size(), digits};
}

bool comes_before(std::string_view a, std::string_view b) {
  const auto whole = std::pair(a, b);
  while (!a.empty() && !b.empty()) {
    if (const auto x = take_run(a, false), y = take_run(b, false); x != y) return x < y;
    if (const auto x = value_of(take_run(a, true)), y = value_of(take_run(b, true)); x != y) return x < y;
  }
  return std::tuple(a.size(), whole.first) < std::tuple(b.size(), whole.second);  // of 1 and 01 the first in ASCII
}

}  // namespace

namespace {

FileFrame read_like(const std::string& file, const scenes::MeshFile* like) {
  scenes::MeshFile read = scenes::read_mesh(file, like);
  for (std::string& note : read.notes) note = file + ": " + note;
  const auto vertex_count = static_cast<uint32_t>(read.positions.size());
  return {{"mesh", vertex_count, std::move(read.triangles), false, std::move(read.edges), std::move(read.points)},
          std::move(read.positions),
          read.is_double,
          std::move(read.polygons),
          std::move(read.notes)};
}

}  // namespace

FileFrame read_frame(const std::string& file) { return read_like(file, nullptr); }

FileFrame read_frame(const std::string& file, const FileFrame& first_frame, const std::string& first_file) {
  const scenes::Mesh& first = first_frame.mesh;
  scenes::MeshFile like;  // polygons that bend from frame to frame keep the triangles of the first
  if (!first_frame.polygons.counts.empty()) like.polygons = first_frame.polygons, like.triangles = first.triangles;
  FileFrame frame = read_like(file, &like);
  check_same("vertices", first_file, first.vertex_count, file, frame.mesh.vertex_count);
  check_same("triangles", first_file, first.triangles.size(), file, frame.mesh.triangles.size());
  for (size_t t = 0; t < first.triangles.size(); ++t)
    if (first.triangles[t] != frame.mesh.triangles[t])
      differ("triangle " + std::to_string(t) + " has other vertices in " + file + " than in " + first_file);
  if (first.edges != frame.mesh.edges || first.points != frame.mesh.points)
    differ(file + " has other loose edges or points than " + first_file);
  return frame;
}

std::vector<std::string> expand_folders(const std::vector<std::string>& names) {
  std::vector<std::string> out;
  for (const std::string& name : names) {
    if (!std::filesystem::is_directory(name)) {
      out.push_back(name);
      continue;
    }
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(name))
      if (scenes::is_mesh_file(entry.path())) found.push_back(entry.path().string());
    if (found.empty()) throw std::runtime_error(name + ": the folder has no mesh files");
    sort_naturally(found);
    out.insert(out.end(), found.begin(), found.end());
  }
  return out;
}

void sort_naturally(std::vector<std::string>& names) { std::sort(names.begin(), names.end(), comes_before); }

}  // namespace collided::cli
