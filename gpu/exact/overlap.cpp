// The product of the winding numbers of meshes A and B changes at the part of A's surface in B and at the part of B's
// surface in A. By the divergence theorem, six times its integral is the sum over all triangles T of a . N: a is a
// corner of T and N is twice the area vector of T's part in the other mesh, weighted by its winding number. N is the
// sum of p x q over the border of that part, which consists of
// - segments in which a triangle of A and one of B meet. They are in both triangles' borders, in opposite directions;
// - parts of edges u v, weighted by the other mesh's winding number w there: t (u x v), where t is the mean of w.
//
// So the sum needs no order, neither of segments along a contour nor of crossings along an edge:
//
//   6 V = sum over segments of (a_A - a_B) . (p x q) + sum over edges of t (a_left - a_right) . (u x v)
//
// Which edges cross which triangles is decided with ties broken (orientation.hpp), that is, for moved meshes in general
// position. Their volume tends to the real one as the moves vanish, and real coordinates give the limit. A crossing
// tends to a point that edge and triangle have in common. If it is not the only one, both are in one plane, and any
// other one gives the same sum: it moves along the edge, which adds to the areas of triangles in that plane alone, and
// to opposite ones.

#include "gpu/exact/overlap.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <vector>

#include "gpu/exact/crossings.hpp"
#include "gpu/exact/fraction.hpp"
#include "gpu/exact/integers.hpp"
#include "gpu/exact/poll.hpp"
#include "gpu/exact/rays.hpp"
#include "gpu/exact/sweep.hpp"

namespace collided {
namespace {

using exact::Bounds;
using exact::Fraction;
using exact::Number;
using exact::NumberedBounds;
using exact::fixed::wide_cross;
using exact::fixed::wide_dot;
using Vector = Vec3<Number>;
using Point = Vec3<double>;

/// An edge of a triangle. Its direction in the table is from u to v.
struct Use {
  uint32_t u, v;  ///< u < v
  uint32_t triangle;
  int direction;  ///< in the triangle: 1 from u to v, -1 from v to u
};

/// The edges of a mesh: each is a run of uses.
struct EdgeTable {
  std::vector<Use> uses;
  std::vector<size_t> begin;  ///< of each edge's uses; one more entry at the end

  explicit EdgeTable(const SolidMesh& mesh) {
    uses.reserve(3 * mesh.triangles.size());
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i)
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
        uses.push_back({std::min(a, b), std::max(a, b), i, a < b ? 1 : -1});
      }
    std::sort(uses.begin(), uses.end(), [](const Use& l, const Use& r) {
      return std::tie(l.u, l.v, l.triangle) < std::tie(r.u, r.v, r.triangle);
    });
    for (size_t i = 0; i < uses.size(); ++i)
      if (i == 0 || uses[i].u != uses[i - 1].u || uses[i].v != uses[i - 1].v) begin.push_back(i);
    begin.push_back(uses.size());
  }
  size_t count() const { return begin.size() - 1; }
  const Use& first(size_t edge) const { return uses[begin[edge]]; }
  std::span<const Use> uses_of(size_t edge) const {
    return std::span(uses).subspan(begin[edge], begin[edge + 1] - begin[edge]);
  }
};

struct Crossing {
  uint32_t edge, triangle;
  int sign;  ///< 1 if the edge, from u to v, enters the other mesh; -1 if it leaves it
};

/// A mesh, and how its edges and vertices are in the other one.
struct Body {
  SolidMesh mesh;
  EdgeTable edges;
  std::vector<Crossing> crossings;     ///< of its edges with the other mesh, by edge and triangle
  std::vector<size_t> crossing_begin;  ///< of each edge; one more entry at the end
  std::vector<int> windings;           ///< the other mesh's winding number around each vertex that an edge has

  explicit Body(const SolidMesh& solid) : mesh(solid), edges(solid) {}

  std::span<const Crossing> crossings_of(size_t edge) const {
    return std::span(crossings).subspan(crossing_begin[edge], crossing_begin[edge + 1] - crossing_begin[edge]);
  }
};

template <size_t n>
Bounds bounds_of(const SolidMesh& mesh, const std::array<uint32_t, n>& vertices) {
  Bounds bounds(mesh.points[vertices[0]]);
  for (const uint32_t v : vertices) bounds.see(Bounds(mesh.points[v]));
  return bounds;
}

void find_crossings(Body& body, const SolidMesh& other) {
  std::vector<NumberedBounds> edges, triangles;
  const SolidMesh& mesh = body.mesh;
  for (uint32_t edge = 0; edge < body.edges.count(); ++edge) {
    const Use& e = body.edges.first(edge);
    edges.push_back({bounds_of(mesh, std::array{e.u, e.v}), edge});
  }
  for (uint32_t i = 0; i < other.triangles.size(); ++i) triangles.push_back({bounds_of(other, other.triangles[i]), i});
  exact::for_each_overlap(std::move(edges), std::move(triangles), [&](uint32_t edge, uint32_t triangle) {
    exact::PollScope::step();
    const Use& e = body.edges.first(edge);
    const auto& [a, b, c] = other.triangles[triangle];
    const EdgeTriangleVerdict verdict =
        exact_edge_triangle({mesh.points[e.u], mesh.points[e.v], other.points[a], other.points[b], other.points[c]},
                            {mesh.ids[e.u], mesh.ids[e.v], other.ids[a], other.ids[b], other.ids[c]});
    if (verdict.crosses) body.crossings.push_back({edge, triangle, verdict.from_front ? 1 : -1});
  });
  std::sort(body.crossings.begin(), body.crossings.end(), [](const Crossing& l, const Crossing& r) {
    return std::tie(l.edge, l.triangle) < std::tie(r.edge, r.triangle);
  });
  size_t next = 0;
  for (size_t edge = 0; edge < body.edges.count(); ++edge) {
    body.crossing_begin.push_back(next);
    while (next < body.crossings.size() && body.crossings[next].edge == edge) ++next;
  }
  body.crossing_begin.push_back(next);
}

/// Follows the ray from a vertex through the other mesh.
int winding_by_ray(const SolidMesh& mesh, uint32_t vertex, const SolidMesh& other) {
  const Point& v = mesh.points[vertex];
  int winding = 0;
  for (uint32_t i = 0; i < other.triangles.size(); ++i) {
    Bounds below = bounds_of(other, other.triangles[i]);
    below.lower[2] = std::min(below.lower[2], v.z);
    if (!below.overlaps(Bounds(v))) continue;
    exact::PollScope::step();
    const auto& [a, b, c] = other.triangles[i];
    winding += exact_ray({v, other.points[a], other.points[b], other.points[c]},
                         {mesh.ids[vertex], other.ids[a], other.ids[b], other.ids[c]})
                   .crossing;
  }
  return winding;
}

/// One ray for each connected part of the mesh is enough: along an edge, crossings tell how the number changes.
void find_windings(Body& body, const SolidMesh& other) {
  const size_t count = body.mesh.points.size();
  std::vector<size_t> begin(count + 1);  // of each vertex's edges
  for (size_t edge = 0; edge < body.edges.count(); ++edge)
    for (const uint32_t v : {body.edges.first(edge).u, body.edges.first(edge).v}) ++begin[v + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<uint32_t> edges(begin.back());
  std::vector<size_t> next(begin.begin(), begin.end() - 1);
  for (uint32_t edge = 0; edge < body.edges.count(); ++edge)
    for (const uint32_t v : {body.edges.first(edge).u, body.edges.first(edge).v}) edges[next[v]++] = edge;

  body.windings.assign(count, 0);
  std::vector<bool> is_known(count);
  std::vector<uint32_t> open;
  const auto know = [&](uint32_t v, int winding) {
    if (is_known[v]) return;
    is_known[v] = true;
    body.windings[v] = winding;
    open.push_back(v);
  };
  for (uint32_t first = 0; first < count; ++first) {
    if (is_known[first] || begin[first] == begin[first + 1]) continue;
    know(first, winding_by_ray(body.mesh, first, other));
    while (!open.empty()) {
      const uint32_t v = open.back();
      open.pop_back();
      for (size_t k = begin[v]; k < begin[v + 1]; ++k) {
        const Use& e = body.edges.first(edges[k]);
        int change = 0;
        for (const Crossing& crossing : body.crossings_of(edges[k])) change += crossing.sign;
        know(e.u == v ? e.v : e.u, body.windings[v] + (e.u == v ? change : -change));
      }
    }
  }
}

/// A point by integer coordinates and a divisor above 0.
struct Place {
  Vector x;
  Number divisor;
};

/// The sum for two meshes, in integers relative to one of their points.
class CommonVolume {
 public:
  CommonVolume(const SolidMesh& a, const SolidMesh& b) : bodies_{Body(a), Body(b)} {
    for (size_t m = 0; m < 2; ++m) {
      find_crossings(bodies_[m], bodies_[1 - m].mesh);
      find_windings(bodies_[m], bodies_[1 - m].mesh);
      unit_.see(bodies_[m].mesh.points);
    }
    origin_ = unit_(any_point());
  }

  /// Returns six times the volume in cubes of the unit.
  Fraction six_times() const {
    exact::FractionSum sum;
    for (size_t m = 0; m < 2; ++m) add_edges(m, sum);
    add_segments(sum);
    return sum.total();
  }
  double in_doubles() const {
    Fraction volume = six_times();
    if (volume.dividend.is_zero()) return 0;
    volume.divisor = volume.divisor * Number(6);
    const double size = std::ldexp(ratio(volume.dividend, volume.divisor), 3 * unit_.exponent());
    return volume.dividend.is_negative() ? -size : size;
  }

 private:
  /// An end of a segment, on an edge of `body`.
  struct End {
    uint32_t triangles[2];  ///< of A and of B, which meet there
    bool is_first;          ///< in the direction of the border of A's part
    uint32_t body, crossing;
  };

  /// A point near the crossings, if there are any, to keep numbers small.
  Point any_point() const {
    for (const Body& body : bodies_)
      if (!body.crossings.empty()) return body.mesh.points[body.edges.first(body.crossings[0].edge).u];
    return bodies_[0].mesh.points.empty() ? Point{} : bodies_[0].mesh.points[0];
  }
  Vector at(size_t body, uint32_t vertex) const { return unit_(bodies_[body].mesh.points[vertex]) - origin_; }
  Vector corner_of(size_t body, uint32_t triangle) const { return at(body, bodies_[body].mesh.triangles[triangle][0]); }

  /// Returns a common point of the crossing's edge and triangle, by weights of u and v.
  exact::fixed::OnEdge<Number> weights_of(size_t body, const Crossing& crossing) const {
    const Use& e = bodies_[body].edges.first(crossing.edge);
    const auto& t = bodies_[1 - body].mesh.triangles[crossing.triangle];
    const Vector points[] = {at(body, e.u), at(body, e.v), at(1 - body, t[0]), at(1 - body, t[1]), at(1 - body, t[2])};
    const uint32_t ids[5] = {};  // the point does not depend on them
    return exact::fixed::EdgeTriangle(points, ids).common_point();
  }
  Place place_of(const End& end) const {
    const Crossing& crossing = bodies_[end.body].crossings[end.crossing];
    const Use& e = bodies_[end.body].edges.first(crossing.edge);
    const auto weights = weights_of(end.body, crossing);
    return {weights.at_u * at(end.body, e.u) + weights.at_v * at(end.body, e.v), weights.at_u + weights.at_v};
  }

  void add_edges(size_t m, exact::FractionSum& sum) const {
    const Body& body = bodies_[m];
    for (size_t edge = 0; edge < body.edges.count(); ++edge) {
      const Use& e = body.edges.first(edge);
      const auto crossings = body.crossings_of(edge);
      if (crossings.empty() && body.windings[e.v] == 0) continue;
      exact::PollScope::step();
      Vector across;
      for (const Use& use : body.edges.uses_of(edge))
        across = across + Number(use.direction) * corner_of(m, use.triangle);
      const Number whole = wide_dot(across, wide_cross(at(m, e.u), at(m, e.v)));
      if (whole.is_zero()) continue;
      sum.add({Number(body.windings[e.v]) * whole});
      for (const Crossing& crossing : crossings) {
        const auto weights = weights_of(m, crossing);
        sum.add({Number(-crossing.sign) * whole * weights.at_v, weights.at_u + weights.at_v});
      }
    }
  }

  /// Each pair of triangles that meet has two ends: the moved triangles share a segment.
  std::vector<End> sorted_ends() const {
    std::vector<End> ends;
    for (uint32_t m = 0; m < 2; ++m)
      for (uint32_t i = 0; i < bodies_[m].crossings.size(); ++i) {
        const Crossing& crossing = bodies_[m].crossings[i];
        for (const Use& use : bodies_[m].edges.uses_of(crossing.edge)) {
          const bool enters = use.direction * crossing.sign > 0;
          End end{{use.triangle, crossing.triangle}, enters == (m == 1), m, i};
          if (m == 1) std::swap(end.triangles[0], end.triangles[1]);
          ends.push_back(end);
        }
      }
    std::sort(ends.begin(), ends.end(), [](const End& l, const End& r) {
      return std::tie(l.triangles[0], l.triangles[1], r.is_first) <
             std::tie(r.triangles[0], r.triangles[1], l.is_first);
    });
    return ends;
  }
  void add_segments(exact::FractionSum& sum) const {
    const std::vector<End> ends = sorted_ends();
    for (size_t i = 0; i < ends.size(); i += 2) {
      exact::PollScope::step();
      const Vector between = corner_of(0, ends[i].triangles[0]) - corner_of(1, ends[i].triangles[1]);
      const Place p = place_of(ends[i]), q = place_of(ends[i + 1]);
      const Number share = wide_dot(between, wide_cross(p.x, q.x));
      if (!share.is_zero()) sum.add({share, p.divisor * q.divisor});
    }
  }

  Body bodies_[2];
  exact::Unit unit_;
  Vector origin_;
};

}  // namespace

double overlap_volume(const SolidMesh& a, const SolidMesh& b) { return CommonVolume(a, b).in_doubles(); }

bool have_common_volume(const SolidMesh& a, const SolidMesh& b) {
  return CommonVolume(a, b).six_times().dividend.sign() > 0;
}

}  // namespace collided
