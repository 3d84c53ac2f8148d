#pragma once
// Affine transforms of nodes, and meshes that nodes place.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "client/scenes/mesh_files/expansion.hpp"
#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

/// Deeper hierarchies are refused.
inline constexpr int kMaxNodeDepth = 256;

/// Three rows of four.
struct Transform {
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  bool operator==(const Transform&) const = default;
  Transform operator*(const Transform& o) const {
    Transform out;
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c)
        out.m[4 * r + c] =
            m[4 * r] * o.m[c] + m[4 * r + 1] * o.m[4 + c] + m[4 * r + 2] * o.m[8 + c] + (c == 3 ? m[4 * r + 3] : 0.0);
    return out;
  }
  Vec3d operator()(const Vec3d& p) const {
    Vec3d out;
    for (size_t r = 0; r < 3; ++r) out[r] = m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] + m[4 * r + 3];
    return out;
  }
  /// True if it turns the inside of a surface out.
  bool is_mirror() const {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
               m[2] * (m[4] * m[9] - m[5] * m[8]) <
           0;
  }
};

/// Copies meshes to where nodes place them, welds each and notes what was done.
class MeshPlacer {
 public:
  MeshPlacer(RawMesh& mesh, Expansion& expansion, const std::string& file, bool welds)
      : mesh_(mesh), expansion_(expansion), file_(file), welds_(welds) {}

  /// `is_counted`: what the part expands to was counted as it was read.
  void place(const RawMesh& part, const Transform& transform, bool is_counted) {
    const size_t vertex = mesh_.positions.size(), corner = mesh_.polygons.corners.size();
    const size_t face = mesh_.polygons.counts.size(), edge = mesh_.edges.size(), point = mesh_.points.size();
    if (part.size() == 0) return;
    if (!is_counted) expansion_.count(part.size());
    if (vertex + part.positions.size() > UINT32_MAX) fail(file_, "has more than 4294967295 vertices");
    mesh_.append(part);
    if (transform != Transform()) move(transform, vertex);
    if (transform.is_mirror()) mirror(face, corner);
    if (welds_) welded_ += weld(mesh_, vertex, corner, edge, point);
    ++placed_;
  }
  void add_notes() {
    if (placed_ > 1) mesh_.notes.push_back("joined " + count_text(placed_, "mesh", "meshes") + " into one");
    if (welded_ > 0)
      mesh_.notes.push_back("welded " + count_text(mesh_.positions.size() + welded_, "vertex", "vertices") + " into " +
                            std::to_string(mesh_.positions.size()));
  }

 private:
  void move(const Transform& transform, size_t first) {
    for (size_t v = first; v < mesh_.positions.size(); ++v) {
      mesh_.positions[v] = transform(mesh_.positions[v]);
      for (const double x : mesh_.positions[v])
        if (!std::isfinite(x)) fail(file_, "a node moves a vertex to a position that is not finite");
    }
  }
  void mirror(size_t face, size_t corner) {
    for (; face < mesh_.polygons.counts.size(); corner += mesh_.polygons.counts[face++])
      std::reverse(mesh_.polygons.corners.begin() + static_cast<std::ptrdiff_t>(corner),
                   mesh_.polygons.corners.begin() + static_cast<std::ptrdiff_t>(corner + mesh_.polygons.counts[face]));
  }

  RawMesh& mesh_;
  Expansion& expansion_;
  const std::string& file_;
  const bool welds_;
  uint64_t placed_ = 0;
  size_t welded_ = 0;
};

}  // namespace collided::scenes
