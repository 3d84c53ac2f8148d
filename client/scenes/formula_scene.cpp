// A scene whose vertices are given by a formula of two parameters and time, and the shared grids.

#include "client/scenes/formula_scene.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "client/scenes/math.hpp"

namespace collided::scenes {

FormulaScene::FormulaScene(std::vector<Part> parts) {
  for (Part& part : parts) {
    part.mesh.vertex_count = static_cast<uint32_t>(part.params.size());
    meshes_.push_back(std::move(part.mesh));
    rules_.push_back({std::move(part.params), std::move(part.formula)});
  }
}

std::vector<Vec3d> FormulaScene::positions(double t) const {
  size_t count = 0;
  for (const Rule& rule : rules_) count += rule.params.size();
  std::vector<Vec3d> out(count);
  Vec3d* first = out.data();
  for (const Rule& rule : rules_) {  // vertices are independent: the number of threads changes no bit
    tbb::parallel_for(size_t{0}, rule.params.size(), [&](size_t i) { first[i] = rule.formula(rule.params[i], t); });
    first += rule.params.size();
  }
  return out;
}

namespace {

double value_at(const Range& range, uint32_t i) {
  if (i == range.quads) return range.last;  // the far border exactly, without rounding
  return range.first + (range.last - range.first) * i / range.quads;
}

}  // namespace

Part grid(std::string name, Range u, Range v, bool wrap_u) {
  Part part;
  part.mesh.name = std::move(name);
  const uint32_t columns = wrap_u ? u.quads : u.quads + 1;
  part.params.reserve(size_t{columns} * (v.quads + 1));
  part.mesh.triangles.reserve(size_t{2} * u.quads * v.quads);
  for (uint32_t j = 0; j <= v.quads; ++j)
    for (uint32_t i = 0; i < columns; ++i) part.params.push_back({value_at(u, i), value_at(v, j)});
  for (uint32_t j = 0; j < v.quads; ++j)
    for (uint32_t i = 0; i < u.quads; ++i) {
      const uint32_t next = (i + 1) % columns;
      const uint32_t a = j * columns + i, b = j * columns + next;
      const uint32_t c = (j + 1) * columns + i, d = (j + 1) * columns + next;
      const bool odd = (i + j) & 1;
      part.mesh.triangles.push_back(odd ? std::array{a, b, c} : std::array{a, b, d});
      part.mesh.triangles.push_back(odd ? std::array{b, d, c} : std::array{a, d, c});
    }
  return part;
}

Part uv_sphere(std::string name, uint32_t lon, uint32_t lat) {
  Part part = grid(std::move(name), {0, 2 * kPi, lon}, {kPi / lat, kPi - kPi / lat, lat - 2}, true);
  const auto north = static_cast<uint32_t>(part.params.size()), south = north + 1, last_row = (lat - 2) * lon;
  part.params.push_back({0, 0});
  part.params.push_back({0, kPi});
  for (uint32_t i = 0; i < lon; ++i) {
    const uint32_t next = (i + 1) % lon;
    part.mesh.triangles.push_back({north, next, i});
    part.mesh.triangles.push_back({south, last_row + i, last_row + next});
  }
  return part;
}

void append(Part& part, const Part& other) {
  const auto base = static_cast<uint32_t>(part.params.size());
  part.params.insert(part.params.end(), other.params.begin(), other.params.end());
  for (const auto& t : other.mesh.triangles) part.mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
}

uint32_t refine(uint32_t n, double scale, uint32_t min) {
  return std::max(min, static_cast<uint32_t>(std::lround(n * scale)));
}

}  // namespace collided::scenes
