#include "tests/gpu/narrow/crossing_judge.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <cmath>

#include "gpu/exact/crossings.hpp"

namespace collided::test {
namespace {

using Exact = std::array<mpz_class, 3>;

/// The exponent of the lowest bit of a number that is not 0.
int lowest_bit(double x) {
  int exponent;
  auto bits = static_cast<int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  exponent -= 53;
  for (; bits % 2 == 0; bits /= 2) ++exponent;
  return exponent;
}

/// The points times one power of two, which makes integers of them.
std::vector<Exact> as_integers(const Positions& positions) {
  int lowest = 1024;
  for (const Vec3d& p : positions)
    for (const double x : p)
      if (x != 0) lowest = std::min(lowest, lowest_bit(x));
  std::vector<Exact> points;
  for (const Vec3d& p : positions) {
    Exact& point = points.emplace_back();
    for (size_t k = 0; k < 3; ++k) {
      int exponent;
      point[k] = std::ldexp(std::frexp(p[k], &exponent), 53);
      exponent -= 53 + lowest;
      if (exponent > 0) point[k] <<= static_cast<mp_bitcnt_t>(exponent);
      if (exponent < 0) point[k] >>= static_cast<mp_bitcnt_t>(-exponent);  // bits that are 0
    }
  }
  return points;
}

Exact minus(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
int orientation(const Exact& a, const Exact& b, const Exact& c, const Exact& d) {
  const Exact p = minus(b, a), q = minus(c, a), r = minus(d, a);
  return sgn(mpz_class(p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
                       p[2] * (q[0] * r[1] - q[1] * r[0])));
}

/// True if the edge u v goes through the triangle; no answer where a determinant is 0.
std::optional<bool> crosses(const Exact& u, const Exact& v, const Exact& a, const Exact& b, const Exact& c) {
  const int from = orientation(a, b, c, u), to = orientation(a, b, c, v);
  if (from * to > 0) return false;
  const int sides[] = {orientation(u, v, a, b), orientation(u, v, b, c), orientation(u, v, c, a)};
  const auto [least, greatest] = std::ranges::minmax(sides);
  if (least < 0 && greatest > 0) return false;
  if (from == 0 || to == 0 || least == 0 || greatest == 0) return std::nullopt;
  return true;
}

struct Box {
  Vec3d lo, hi;
  uint32_t id;

  bool overlaps(const Box& other) const {
    for (size_t k = 0; k < 3; ++k)
      if (lo[k] > other.hi[k] || other.lo[k] > hi[k]) return false;
    return true;
  }
};

template <class Vertices>
Box box_of(const Positions& positions, const Vertices& vertices, uint32_t id) {
  Box box{positions[vertices[0]], positions[vertices[0]], id};
  for (const uint32_t v : vertices)
    for (size_t k = 0; k < 3; ++k) {
      box.lo[k] = std::min(box.lo[k], positions[v][k]);
      box.hi[k] = std::max(box.hi[k], positions[v][k]);
    }
  return box;
}

/// use(edge, triangle) for all whose boxes overlap. Comparisons are exact.
template <class Use>
void sweep(const Surface& surface, const Use& use) {
  std::vector<Box> triangles;
  double widest = 0;
  for (uint32_t t = 0; t < surface.topology.triangles.size(); ++t) {
    if (surface.is_loose(t)) continue;
    triangles.push_back(box_of(surface.positions, surface.topology.triangles[t], t));
    widest = std::max(widest, triangles.back().hi[0] - triangles.back().lo[0]);
  }
  std::ranges::sort(triangles, {}, [](const Box& box) { return box.lo[0]; });
  for (uint32_t e = 0; e < surface.topology.edges.size(); ++e) {
    const Box edge = box_of(surface.positions, surface.topology.edges[e], e);
    const double first =
        std::nextafter(edge.lo[0] - 1.001 * widest, -HUGE_VAL);  // no box that begins before it reaches the edge
    for (auto box = std::ranges::lower_bound(triangles, first, {}, [](const Box& b) { return b.lo[0]; });
         box != triangles.end() && box->lo[0] <= edge.hi[0]; ++box)
      if (edge.overlaps(*box)) use(e, box->id);
  }
}

}  // namespace

Surface::Surface(const Case& c) : topology(Detector::create(spec_for(c, {}))->topology()) {
  for (const Positions& mesh : c.end) positions.insert(positions.end(), mesh.begin(), mesh.end());
}

bool Surface::share_vertex(size_t e, size_t t) const {
  const auto& triangle = topology.triangles[t];
  return std::ranges::find_first_of(topology.edges[e], triangle) != topology.edges[e].end();
}

std::vector<PairKey> JudgedCrossings::all() const {
  std::vector<PairKey> both;
  std::ranges::merge(sure, tied, std::back_inserter(both));
  return both;
}

std::optional<bool> goes_through(const std::array<Vec3d, 2>& edge, const std::array<Vec3d, 3>& triangle) {
  const std::vector<Exact> p = as_integers({edge[0], edge[1], triangle[0], triangle[1], triangle[2]});
  return crosses(p[0], p[1], p[2], p[3], p[4]);
}

JudgedCrossings judge_crossings(const Surface& surface) {
  JudgedCrossings judged;
  const std::vector<Exact> points = as_integers(surface.positions);
  const auto at = [&](uint32_t id) {
    const Vec3d& p = surface.positions[id];
    return Vec3<double>{p[0], p[1], p[2]};
  };
  sweep(surface, [&](uint32_t e, uint32_t t) {
    if (surface.share_vertex(e, t)) return;
    const auto [u, v] = surface.topology.edges[e];
    const auto [a, b, c] = surface.topology.triangles[t];
    const std::optional<bool> answer = crosses(points[u], points[v], points[a], points[b], points[c]);
    if (answer == false) return;
    if (answer) return judged.sure.push_back(key_of(e, t));
    if (exact_edge_triangle({at(u), at(v), at(a), at(b), at(c)}, {u, v, a, b, c}).crosses)
      judged.tied.push_back(key_of(e, t));
  });
  std::ranges::sort(judged.sure);
  std::ranges::sort(judged.tied);
  return judged;
}

std::map<PairKey, uint32_t> contour_ends(std::span<const std::array<uint32_t, 2>> crossings, const Topology& topology) {
  std::map<std::array<uint32_t, 2>, std::vector<uint32_t>> triangles_of;
  for (uint32_t t = 0; t < topology.triangles.size(); ++t)
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = topology.triangles[t][k], w = topology.triangles[t][(k + 1) % 3];
      triangles_of[{std::min(v, w), std::max(v, w)}].push_back(t);
    }
  std::map<PairKey, uint32_t> ends;
  for (const auto& [edge, through] : crossings)
    for (const uint32_t t : triangles_of[topology.edges[edge]])
      ++ends[key_of(std::min(t, through), std::max(t, through))];
  return ends;
}

}  // namespace collided::test
