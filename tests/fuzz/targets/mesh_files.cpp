// Mesh files of every format: whatever is in them, a mesh or a refusal, and a mesh is the same once written and read
// again.

#include <algorithm>
#include <cmath>

#include "client/scenes/mesh_files/mesh_text.hpp"
#include "tests/fuzz/targets/fuzz.hpp"

namespace collided::fuzz {
namespace {

using scenes::MeshFile;

bool is_finite(const MeshFile& mesh) {
  return std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const auto& p) {
    return std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); });
  });
}

template <class Elements>
void check_elements(const MeshFile& mesh, const Elements& elements) {
  for (const auto& element : elements)
    for (const uint32_t v : element) require(v < mesh.positions.size(), "elements have vertices that there are");
}

void check_same(const MeshFile& mesh, const MeshFile& again) {
  require(mesh.positions == again.positions, "a written mesh has the same positions, to the bit");
  require(mesh.triangles == again.triangles, "a written mesh has the same triangles");
}

void check(const MeshFile& mesh) {
  check_elements(mesh, mesh.triangles);
  check_elements(mesh, mesh.edges);
  for (const uint32_t v : mesh.points) require(v < mesh.positions.size(), "points have vertices that there are");
  require(is_finite(mesh), "positions are finite");
  if (mesh.triangles.empty()) return;
  check_same(mesh, scenes::parse_mesh(".obj", scenes::write_obj(mesh), "written.obj"));
  check_same(mesh, scenes::parse_mesh(".ply", scenes::write_ply(mesh), "written.ply"));
}

/// By how the text begins; what begins like none is OBJ.
std::string extension_of(const std::string& text) {
  const auto begins = [&](std::string_view with) { return text.starts_with(with); };
  if (begins("ply")) return ".ply";
  if (begins("solid") || begins("STL")) return ".stl";
  if (begins("OFF") || begins("COFF") || begins("NOFF") || begins("4OFF")) return ".off";
  if (begins("glTF") || begins("{")) return ".gltf";
  return begins("<") ? ".dae" : ".obj";
}

void read(const std::string& text) {
  MeshFile mesh;
  const std::string extension = extension_of(text);
  try {
    mesh = scenes::parse_mesh(extension, text, "input" + extension);
  } catch (const std::runtime_error& e) {
    require(std::string(e.what()).starts_with("input."), "a refusal names the file");
    return;
  }
  check(mesh);
}

}  // namespace

void run(Input input) { read(input.rest()); }

}  // namespace collided::fuzz
