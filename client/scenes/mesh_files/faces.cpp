// What all formats share once a file is parsed: indices are checked, repeated corners dropped, faces split.

#include "client/scenes/mesh_files/faces.hpp"

#include <cstring>
#include <unordered_map>
#include <utility>

#include "client/scenes/mesh_files/polygons.hpp"

namespace collided::scenes {

namespace {

void check_index(uint32_t index, const RawMesh& raw, const std::string& place) {
  if (index >= raw.positions.size())
    fail(place, "vertex index " + std::to_string(index) + " is out of range; " + vertices_there(raw.positions.size()));
}

/// Calls visit(face, first corner) for all faces.
template <class Visit>
void for_each_face(const Polygons& polygons, const Visit& visit) {
  size_t at = 0;
  for (size_t face = 0; face < polygons.counts.size(); at += polygons.counts[face++]) visit(face, at);
}

class Splitter {
 public:
  Splitter(RawMesh& raw, const std::string& file) : raw_(raw), file_(file) {}

  void check() const {
    for_each_face(raw_.polygons, [&](size_t face, size_t at) {
      const uint32_t count = raw_.polygons.counts[face];
      if (count < 3) fail(place(face), "the face has " + count_text(count, "corner") + "; it needs 3");
      for (size_t i = at; i < at + count; ++i)
        if (raw_.polygons.corners[i] >= raw_.positions.size()) check_index(raw_.polygons.corners[i], raw_, place(face));
    });
    for (size_t i = 0; i < raw_.edges.size(); ++i)
      for (const uint32_t v : raw_.edges[i]) check_index(v, raw_, file_ + ": edge " + std::to_string(i));
    for (size_t i = 0; i < raw_.points.size(); ++i)
      check_index(raw_.points[i], raw_, file_ + ": point " + std::to_string(i));
  }

  /// Drops corners that repeat the one before them, and faces that then have fewer than three.
  void drop_repeated_corners() {
    Polygons kept;
    std::vector<uint32_t> lines;
    uint64_t corners = 0, faces = 0;
    for_each_face(raw_.polygons, [&](size_t face, size_t at) {
      const uint32_t count = raw_.polygons.counts[face];
      const uint32_t* const given = &raw_.polygons.corners[at];
      const size_t start = kept.corners.size();
      for (uint32_t i = 0; i < count; ++i)
        if (given[i] != given[(i + 1) % count]) kept.corners.push_back(given[i]);
      const size_t left = kept.corners.size() - start;
      corners += left < 3 ? 0 : count - left;
      faces += left < 3;
      if (left < 3) return kept.corners.resize(start);
      kept.counts.push_back(static_cast<uint32_t>(left));
      if (!raw_.lines.empty()) lines.push_back(raw_.lines[face]);
    });
    if (corners > 0) raw_.notes.push_back("dropped " + count_text(corners, "repeated corner"));
    if (faces > 0)
      raw_.notes.push_back("dropped " + count_text(faces, "face") + " with fewer than 3 different corners");
    raw_.polygons = std::move(kept);
    raw_.lines = std::move(lines);
  }

  std::vector<std::array<uint32_t, 3>> triangles() const {
    std::vector<std::array<uint32_t, 3>> out;
    out.reserve(raw_.polygons.counts.size());
    for_each_face(raw_.polygons, [&](size_t face, size_t at) { split(face, &raw_.polygons.corners[at], out); });
    return out;
  }

 private:
  /// Where a face is in the file.
  std::string place(size_t face) const {
    return raw_.lines.empty() ? file_ + ": face " + std::to_string(face)
                              : file_ + ":" + std::to_string(raw_.lines[face]);
  }

  void split(size_t face, const uint32_t* corners, std::vector<std::array<uint32_t, 3>>& out) const {
    const uint32_t count = raw_.polygons.counts[face];
    if (count == 3) return out.push_back({corners[0], corners[1], corners[2]});
    std::vector<Vec3d> positions;
    for (uint32_t i = 0; i < count; ++i) {
      positions.push_back(raw_.positions[corners[i]]);
      for (const double x : positions.back())
        if (!std::isfinite(x))
          fail(place(face), "vertex " + std::to_string(corners[i]) + " has a position that is not finite");
    }
    const auto triangles = split_polygon(positions);
    if (!triangles && count > kMaxConcaveCorners)
      fail(place(face), "the face of " + std::to_string(count) + " corners is not convex; such faces may have " +
                            std::to_string(kMaxConcaveCorners));
    if (!triangles) fail(place(face), "the face of " + std::to_string(count) + " corners crosses itself");
    for (const auto& t : *triangles) out.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
  }

  RawMesh& raw_;
  const std::string& file_;
};

struct HashPosition {
  size_t operator()(const Vec3d& p) const {
    uint64_t hash = 0;
    for (const double x : p) {
      uint64_t bits = 0;
      std::memcpy(&bits, &x, sizeof bits);
      hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return hash;
  }
};

}  // namespace

MeshFile split_faces(RawMesh raw, const std::string& file, const MeshFile* like) {
  Splitter splitter(raw, file);
  splitter.check();
  splitter.drop_repeated_corners();
  MeshFile mesh;
  const bool is_known = like && !like->polygons.counts.empty() && like->polygons == raw.polygons;
  mesh.triangles = is_known ? like->triangles : splitter.triangles();
  if (mesh.triangles.size() > raw.polygons.counts.size()) mesh.polygons = std::move(raw.polygons);
  mesh.positions = std::move(raw.positions);
  mesh.edges = std::move(raw.edges);
  mesh.points = std::move(raw.points);
  mesh.notes = std::move(raw.notes);
  return mesh;
}

size_t weld(RawMesh& mesh, size_t first, size_t first_corner, size_t first_edge, size_t first_point) {
  std::unordered_map<Vec3d, uint32_t, HashPosition> known;
  std::vector<uint32_t> new_index;
  size_t kept = first;
  for (size_t v = first; v < mesh.positions.size(); ++v) {
    Vec3d position = mesh.positions[v];
    for (double& x : position) x += 0.0;  // -0 and 0 are one position
    const auto [at, is_new] = known.try_emplace(position, static_cast<uint32_t>(kept));
    if (is_new) mesh.positions[kept++] = mesh.positions[v];
    new_index.push_back(at->second);
  }
  const size_t welded = mesh.positions.size() - kept;
  mesh.positions.resize(kept);
  const auto map = [&](uint32_t& v) { v = new_index[v - first]; };
  for (size_t i = first_corner; i < mesh.polygons.corners.size(); ++i) map(mesh.polygons.corners[i]);
  for (size_t i = first_edge; i < mesh.edges.size(); ++i) map(mesh.edges[i][0]), map(mesh.edges[i][1]);
  for (size_t i = first_point; i < mesh.points.size(); ++i) map(mesh.points[i]);
  return welded;
}

}  // namespace collided::scenes
