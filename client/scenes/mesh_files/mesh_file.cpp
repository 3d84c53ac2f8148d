// Reads and writes mesh files: picks the format and checks what was read.

#include "client/scenes/mesh_files/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <locale>
#include <new>
#include <sstream>
#include <utility>

#include "client/scenes/mesh_files/faces.hpp"
#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{8} << 30;

using Reader = RawMesh (*)(std::string_view text, const std::string& file);

constexpr std::array<std::pair<std::string_view, Reader>, 7> kReaders{{{".obj", read_obj},
                                                                       {".ply", read_ply},
                                                                       {".stl", read_stl},
                                                                       {".off", read_off},
                                                                       {".gltf", read_gltf},
                                                                       {".glb", read_gltf},
                                                                       {".dae", read_dae}}};

/// The file's extension in lower case.
std::string extension_of(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

/// Null if there is none.
Reader find_reader(const std::string& extension) {
  for (const auto& [known, reader] : kReaders)
    if (known == extension) return reader;
  return nullptr;
}

Reader reader_of(const std::string& extension, const std::string& file) {
  if (const Reader reader = find_reader(extension)) return reader;
  fail(file, "the extension must be " + std::string(kMeshExtensions));
}

/// Names the file if there is no memory for what `read` makes of it.
template <class Read>
auto in_memory(const std::string& file, const Read& read) {
  try {
    return read();
  } catch (const std::bad_alloc&) {
    fail(file, "does not fit in memory");
  } catch (const std::length_error&) {
    fail(file, "does not fit in memory");
  }
}

void check(MeshFile& mesh, const std::string& file) {
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    for (const double x : mesh.positions[v]) {
      if (!std::isfinite(x)) fail(file, "vertex " + std::to_string(v) + " has a position that is not finite");
      if (std::abs(x) > 3.4e38 || static_cast<double>(static_cast<float>(x)) != x) mesh.is_double = true;
    }
  const bool is_loose = !mesh.edges.empty() || !mesh.points.empty();
  if (mesh.positions.size() < 3 && !is_loose)
    fail(file, "has " + count_text(mesh.positions.size(), "vertex", "vertices") + "; a mesh needs 3");
  if (mesh.triangles.empty() && !is_loose) fail(file, "has no faces");
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

bool is_mesh_file(const std::filesystem::path& file) { return find_reader(extension_of(file)) != nullptr; }

MeshFile parse_mesh(const std::string& extension, std::string_view text, const std::string& file,
                    const MeshFile* like) {
  const Reader reader = reader_of(extension, file);
  return in_memory(file, [&] {
    MeshFile mesh = split_faces(reader(text, file), file, like);
    check(mesh, file);
    return mesh;
  });
}

MeshFile read_mesh(const std::filesystem::path& file, const MeshFile* like) {
  const std::string extension = extension_of(file);
  reader_of(extension, file.string());
  const std::string text = in_memory(file.string(), [&] { return read_file(file); });
  return parse_mesh(extension, text, file.string(), like);
}

void write_mesh(const std::filesystem::path& file, const MeshFile& mesh) {
  if (!mesh.edges.empty() || !mesh.points.empty()) fail(file.string(), "loose edges and points cannot be written");
  const std::string extension = extension_of(file);
  if (extension != ".obj" && extension != ".ply")
    fail(file.string(), "the extension must be .obj or .ply to be written");
  write_file(file, extension == ".obj" ? write_obj(mesh) : write_ply(mesh));
}

}  // namespace collided::scenes
