// Reads and writes mesh files: picks the format and checks what was read.

#include "client/scenes/mesh_files/mesh_file.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{8} << 30;

/// The file's extension in lower case.
std::string ending_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending != ".obj" && ending != ".ply") fail(file.string(), "ending '" + ending + "' is neither .obj nor .ply");
  return ending;
}

void check(MeshFile& mesh, const std::string& file) {
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    for (const double x : mesh.positions[v]) {
      if (!std::isfinite(x)) fail(file, "vertex " + std::to_string(v) + " has a position that is not finite");
      if (std::abs(x) > 3.4e38 || static_cast<double>(static_cast<float>(x)) != x) mesh.is_double = true;
    }
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const uint32_t v : mesh.triangles[t])
      if (v >= mesh.positions.size())
        fail(file, "triangle " + std::to_string(t) + " has vertex " + std::to_string(v) + "; there are " +
                       std::to_string(mesh.positions.size()) + " vertices");
  const bool is_loose = !mesh.edges.empty() || !mesh.points.empty();
  if (mesh.positions.size() < 3 && !is_loose)
    fail(file, "has " + std::to_string(mesh.positions.size()) + " vertices; a mesh needs 3");
  if (mesh.triangles.empty() && !is_loose) fail(file, "has no triangles");
}

}  // namespace

std::string read_file(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!status_known(status)) fail(file.string(), "cannot be read: " + error.message());
  if (is_directory(status)) fail(file.string(), "is a folder");
  if (!exists(status)) fail(file.string(), "does not exist");
  if (!is_regular_file(status)) fail(file.string(), "is not a file");
  const uint64_t bytes = std::filesystem::file_size(file, error);
  if (error) fail(file.string(), error.message());
  if (bytes > kMaxFileBytes)
    fail(file.string(), "is " + std::to_string(bytes) + " bytes; the limit is " + std::to_string(kMaxFileBytes));
  std::string text(bytes, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(text.data(), static_cast<std::streamsize>(bytes))) fail(file.string(), "cannot be read");
  return text;
}

bool is_underflow(std::string_view word) {
  std::istringstream in{std::string(word)};
  in.imbue(std::locale::classic());
  double value = 0;
  return static_cast<bool>(in >> value);  // which fails for numbers that are too large
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!out.flush()) fail(file.string(), "cannot be written");
}

void add_fan(const std::vector<uint32_t>& corners, MeshFile& mesh, const std::string& place) {
  if (corners.size() < 3) fail(place, "the face has " + std::to_string(corners.size()) + " corners; it needs 3");
  for (size_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

MeshFile read_mesh(const std::filesystem::path& file) {
  const std::string ending = ending_of(file), text = read_file(file);
  MeshFile mesh = ending == ".obj" ? read_obj(text, file.string()) : read_ply(text, file.string());
  check(mesh, file.string());
  return mesh;
}

void write_mesh(const std::filesystem::path& file, const MeshFile& mesh) {
  if (!mesh.edges.empty() || !mesh.points.empty()) fail(file.string(), "loose edges and points cannot be written");
  write_file(file, ending_of(file) == ".obj" ? write_obj(mesh) : write_ply(mesh));
}

}  // namespace collided::scenes
