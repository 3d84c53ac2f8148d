// Writes PLY: binary little-endian with double positions, so that every position is kept bit for bit.

#include <bit>

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

template <class Bits>
void append_little_endian(std::string& out, Bits bits) {
  for (size_t i = 0; i < sizeof(Bits); ++i) out += static_cast<char>(bits >> (8 * i) & 0xFF);
}

}  // namespace

std::string write_ply(const MeshFile& mesh) {
  std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.positions.size()) +
                    "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                    std::to_string(mesh.triangles.size()) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  out.reserve(out.size() + 24 * mesh.positions.size() + 13 * mesh.triangles.size());
  for (const Vec3d& p : mesh.positions)
    for (const double x : p) append_little_endian(out, std::bit_cast<uint64_t>(x));
  for (const auto& t : mesh.triangles) {
    out += '\3';
    for (const uint32_t v : t) append_little_endian(out, v);
  }
  return out;
}

}  // namespace collided::scenes
