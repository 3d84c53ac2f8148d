#include "tests/gpu/solids/solid_scenes.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace collided::test {
namespace {

using Cell = std::array<int, 3>;

Vec3d as_point(const Cell& cell) {
  return {static_cast<double>(cell[0]), static_cast<double>(cell[1]), static_cast<double>(cell[2])};
}
Shape cube_at(const Cell& cell) {
  const Vec3d lo = as_point(cell);
  return box(lo, {lo[0] + 1, lo[1] + 1, lo[2] + 1});
}

/// The border of a set of cells, as triangles that face outward and share vertices.
Shape border_of(const std::vector<Cell>& cells) {
  Shape border;
  std::map<Vec3d, uint32_t> ids;
  const auto id_of = [&](const Vec3d& p) {
    const auto [found, is_new] = ids.emplace(p, static_cast<uint32_t>(border.positions.size()));
    if (is_new) border.positions.push_back(p);
    return found->second;
  };
  for (const Cell& cell : cells) {
    const Shape cube = cube_at(cell);
    for (size_t side = 0; side < 6; ++side) {  // of box(): z, y, x, each lower and upper; two triangles each
      Cell beyond = cell;
      beyond[2 - side / 2] += side % 2 == 0 ? -1 : 1;
      if (std::ranges::find(cells, beyond) != cells.end()) continue;
      for (size_t k = 0; k < 2; ++k) {
        const auto& t = cube.triangles[2 * side + k];
        border.triangles.push_back(
            {id_of(cube.positions[t[0]]), id_of(cube.positions[t[1]]), id_of(cube.positions[t[2]])});
      }
    }
  }
  return border;
}

/// 1 within the box.
int winding_of(const std::array<Vec3d, 2>& box, const Cell& cell) {
  for (size_t k = 0; k < 3; ++k)
    if (cell[k] < box[0][k] || cell[k] >= box[1][k]) return 0;
  return 1;
}

}  // namespace

Vec3d RandomBodies::point(int size) { return as_point({below(size + 1), below(size + 1), below(size + 1)}); }
std::array<Vec3d, 2> RandomBodies::corners(int size) {
  std::array<Vec3d, 2> out;
  for (size_t k = 0; k < 3; ++k) {
    const int lo = below(size);
    out[0][k] = lo, out[1][k] = lo + 1 + below(size - lo);
  }
  return out;
}

Body RandomBodies::tetrahedron(int size) {
  Positions corners;
  do corners = {point(size), point(size), point(size), point(size)};
  while (volume6(corners) == 0);
  const Shape shape = test::tetrahedron(corners);
  return {shape, {{shape}}};
}
Body RandomBodies::convex(int size) {
  const int kind = below(3);
  if (kind == 0) return tetrahedron(size);
  const auto [lo, hi] = corners(size);
  if (kind == 1) return {box(lo, hi), {{box(lo, hi)}}};
  Shape octahedron;  // lower x, upper x, lower y, ... around a point within
  Vec3d centre;
  for (size_t k = 0; k < 3; ++k) centre[k] = lo[k] + (hi[k] - lo[k] > 1 ? 1 : 0.5);
  for (size_t i = 0; i < 6; ++i) {
    octahedron.positions.push_back(centre);
    octahedron.positions.back()[i / 2] = i % 2 == 0 ? lo[i / 2] : hi[i / 2];
  }
  for (uint32_t i = 0; i < 8; ++i) {
    std::array<uint32_t, 3> t{i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2 & 1)};
    if (((i & 1) + (i >> 1 & 1) + (i >> 2 & 1)) % 2 == 0) std::swap(t[1], t[2]);
    octahedron.triangles.push_back(t);
  }
  return {octahedron, {{octahedron}}};
}
Body RandomBodies::cells(int size) {
  std::vector<Cell> cells;
  for (int x = 0; x < size; ++x)
    for (int y = 0; y < size; ++y)
      for (int z = 0; z < size; ++z)
        if (below(3) != 0) cells.push_back({x, y, z});
  if (cells.empty()) cells.push_back({0, 0, 0});
  Body body{border_of(cells), {}};
  for (const Cell& cell : cells) body.pieces.within.push_back(cube_at(cell));
  return body;
}
Body RandomBodies::two_boxes(int size, bool is_inside_out) {
  const auto volume = [](const auto& box) {
    return (box[1][0] - box[0][0]) * (box[1][1] - box[0][1]) * (box[1][2] - box[0][2]);
  };
  std::array<Vec3d, 2> first = corners(size), second = corners(size);
  if (is_inside_out)
    while (volume(first) <= volume(second)) first = corners(size), second = corners(size);
  Shape other = box(second[0], second[1]);
  Body body{together(box(first[0], first[1]), is_inside_out ? reversed(other) : other), {}};
  for (int x = 0; x < size; ++x)
    for (int y = 0; y < size; ++y)
      for (int z = 0; z < size; ++z) {
        const Cell cell{x, y, z};
        const int winding = winding_of(first, cell) + (is_inside_out ? -1 : 1) * winding_of(second, cell);
        if (winding > 0) body.pieces.within.push_back(cube_at(cell));
        if (is_inside_out && winding_of(second, cell) > 0) body.pieces.inside_out.push_back(cube_at(cell));
      }
  return body;
}
Body RandomBodies::any(int size) {
  const int kind = below(10);
  if (kind < 6) return convex(size);
  if (kind < 8) return cells(std::min(size, 3));
  return two_boxes(size, kind == 9);
}

MeshSpec RandomBodies::loose(int size, Positions& positions) {
  MeshSpec mesh;
  const auto add = [&] {
    positions.push_back(point(size));
    return static_cast<uint32_t>(positions.size() - 1);
  };
  add();  // no element's
  const uint32_t first = add(), second = add();
  const int kind = below(4);
  if (kind < 2) {
    for (int i = below(3); i >= 0; --i) mesh.triangles.push_back({first, second, add()});
  }
  if (kind == 1 || kind == 2) mesh.edges.push_back({second, add()});
  if (kind == 3) mesh.points = {first, second};
  mesh.vertex_count = static_cast<uint32_t>(positions.size());
  return mesh;
}

Body RandomBodies::shuffled(Body body) {
  Shape& shape = body.surface;
  if (below(4) == 0) shape.positions.push_back(point(3));
  std::vector<uint32_t> now(shape.positions.size());
  std::iota(now.begin(), now.end(), 0u);
  std::ranges::shuffle(now, random_);
  const Positions was = shape.positions;
  for (size_t v = 0; v < was.size(); ++v) shape.positions[now[v]] = was[v];
  std::ranges::shuffle(shape.triangles, random_);
  for (auto& t : shape.triangles) {
    for (uint32_t& v : t) v = now[v];
    std::ranges::rotate(t, t.begin() + below(3));
  }
  return body;
}

Body moved(Body body, const Vec3d& by, double scale) {
  const auto move = [&](Shape& shape) {
    for (Vec3d& p : shape.positions)
      for (size_t k = 0; k < 3; ++k) p[k] = scale * (p[k] + by[k]);
  };
  move(body.surface);
  for (auto* some : {&body.pieces.within, &body.pieces.inside_out})
    for (Shape& piece : *some) move(piece);
  return body;
}

void add_solid(SolidsScene& scene, const Body& body) {
  add_mesh(scene.c, body.surface.triangles, body.surface.positions);
  scene.c.meshes.back().self_contacts = false;
  scene.c.meshes.back().solid = true;
  scene.pieces.push_back(body.pieces);
}
void add_surface(SolidsScene& scene, const MeshSpec& mesh, const Positions& positions) {
  add_mesh(scene.c, mesh.triangles, positions);
  scene.c.meshes.back() = mesh;
  scene.c.meshes.back().self_contacts = false;
  scene.pieces.emplace_back();
}

}  // namespace collided::test
