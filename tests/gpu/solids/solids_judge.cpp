#include "tests/gpu/solids/solids_judge.hpp"

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "tests/gpu/solids/exact_meetings.hpp"
#include "tests/gpu/solids/exact_scaling.hpp"

namespace collided::test {
namespace {

/// Of all coordinates; 0 if all are 0.
int lowest_bit_of(const SolidsScene& scene) {
  int lowest = 1024;
  const auto add = [&](const Positions& positions) {
    for (const Vec3d& p : positions)
      for (const double x : p)
        if (x != 0) lowest = std::min(lowest, lowest_bit(x));
  };
  for (const Positions& mesh : scene.c.end) add(mesh);
  for (const Pieces& pieces : scene.pieces)
    for (const auto* some : {&pieces.within, &pieces.inside_out})
      for (const Shape& piece : *some) add(piece.positions);
  return lowest == 1024 ? 0 : lowest;
}

template <class N>
struct Bounds {
  Vector<N> lo, hi;

  void add(const Vector<N>& p) {
    for (size_t k = 0; k < 3; ++k) lo[k] = std::min(lo[k], p[k]), hi[k] = std::max(hi[k], p[k]);
  }
  bool meets(const Bounds& other) const {
    for (size_t k = 0; k < 3; ++k)
      if (lo[k] > other.hi[k] || other.lo[k] > hi[k]) return false;
    return true;
  }
};
template <class N>
Bounds<N> bounds_of_points(std::initializer_list<Vector<N>> points) {
  Bounds<N> bounds{*points.begin(), *points.begin()};
  for (const Vector<N>& p : points) bounds.add(p);
  return bounds;
}

/// The vertices of an element: one, two or three of them.
using Element = std::vector<uint32_t>;

template <class N>
struct Mesh {
  bool is_solid = false;
  std::vector<Element> elements;  ///< those of a solid are all triangles
  std::vector<Bounds<N>> element_bounds;
  std::vector<Triangle<N>> triangles;  ///< the first elements
  uint32_t first_triangle = 0;         ///< scene-wide id
  std::set<uint32_t> used;             ///< vertices, scene-wide
  std::set<std::array<uint32_t, 2>> edges;
  std::vector<Convex<N>> within, inside_out;
  Bounds<N> bounds;
};

/// Where a point is with regard to a solid.
struct Place {
  bool is_on = false;
  int winding = 0;

  bool is_inside() const { return !is_on && winding > 0; }
};

/// A point of the scene, place / under from `origin`.
template <class N>
struct FractionPoint {
  Vector<N> origin, place = {};
  N under = 1;
};

/// Adds what a ray from the origin does at a triangle. Returns false if that cannot be told for it meets the border.
template <class N>
bool add_crossing(const Triangle<N>& t, const Vector<N>& direction, int& winding) {
  if (is_zero(t.normal())) return true;
  const int first = sign(dot(direction, cross(t.a, t.b))), second = sign(dot(direction, cross(t.b, t.c))),
            third = sign(dot(direction, cross(t.c, t.a)));
  if (std::min({first, second, third}) < 0 && std::max({first, second, third}) > 0) return true;
  if (first == 0 || second == 0 || third == 0) return false;
  if (sign(dot(t.a, cross(t.b, t.c))) == first) winding += first;  // the crossing is ahead
  return true;
}

template <class N>
Place place_in(const Mesh<N>& mesh, const FractionPoint<N>& point) {
  std::vector<Triangle<N>> seen;
  seen.reserve(mesh.triangles.size());
  for (const Triangle<N>& triangle : mesh.triangles) {
    const Triangle<N> t = triangle.from(point.origin);
    seen.push_back({times(t.a, point.under) - point.place, times(t.b, point.under) - point.place,
                    times(t.c, point.under) - point.place});
    if (is_on_triangle<N>({}, seen.back())) return {true, 0};
  }
  for (int attempt = 0; attempt < 100; ++attempt) {
    const Vector<N> direction{N(311 + 17 * attempt), N(-197 + 29 * attempt), N(89 - 31 * attempt)};
    Place place;
    if (std::ranges::all_of(seen, [&](const auto& t) { return add_crossing(t, direction, place.winding); }))
      return place;
  }
  throw std::logic_error("all rays meet borders");
}

template <class N>
class Judge : public SolidsJudge {
 public:
  explicit Judge(const SolidsScene& scene) : scene_(scene), unit_(lowest_bit_of(scene)) {
    for (size_t m = 0; m < scene.c.meshes.size(); ++m) add_mesh(m);
  }

  JudgedSolids judge() const override {
    JudgedSolids judged;
    for (uint32_t i = 0; i < meshes_.size(); ++i)
      for (uint32_t j = i + 1; j < meshes_.size(); ++j)
        if (may_touch(i, j) && !meshes_[i].used.empty() && !meshes_[j].used.empty() &&
            meshes_[i].bounds.meets(meshes_[j].bounds))
          judge_pair(i, j, judged);
    std::ranges::sort(judged.inside, {}, [](const JudgedInside& one) { return std::array{one.vertex, one.mesh}; });
    return judged;
  }

  long double distance(uint32_t vertex, uint32_t triangle) const override {
    return length_of(nearest(vertex, triangle).squared);
  }

  JudgedSign of_vertex_triangle(const std::array<uint32_t, 2>& ids) const override {
    const uint32_t mesh = mesh_of_vertex_[ids[0]], other = mesh_of_element_[ids[1]];
    const Nearest<N> at = nearest(ids[0], ids[1]);
    const FractionPoint<N> first{points_[ids[0]]}, second{points_[ids[0]], at.place, at.under};
    return sign_of({{ids[0]}, mesh}, {element(ids[1]), other}, {first, second});
  }
  JudgedSign of_edge_edge(const std::array<uint32_t, 2>& ids) const override {
    const auto &a = edges_[ids[0]].second, &b = edges_[ids[1]].second;
    return sign_of({{a[0], a[1]}, edges_[ids[0]].first}, {{b[0], b[1]}, edges_[ids[1]].first}, closest_of_edges(a, b));
  }

 private:
  using ClosestPoints = std::array<FractionPoint<N>, 2>;
  struct Feature {
    Element vertices;
    uint32_t mesh;
  };

  void add_mesh(size_t m) {
    const MeshSpec& spec = scene_.c.meshes[m];
    const auto first = static_cast<uint32_t>(points_.size());
    Mesh<N>& mesh = meshes_.emplace_back();
    mesh.is_solid = spec.solid, mesh.first_triangle = static_cast<uint32_t>(mesh_of_element_.size());
    for (const Vec3d& p : scene_.c.end[m]) points_.push_back(as_integers<N>(p, unit_));
    mesh_of_vertex_.resize(points_.size(), static_cast<uint32_t>(m));
    for (const auto& t : spec.triangles) mesh.elements.push_back({first + t[0], first + t[1], first + t[2]});
    for (const auto& e : spec.edges) mesh.elements.push_back({first + e[0], first + e[1]});
    for (const uint32_t v : spec.points) mesh.elements.push_back({first + v});
    for (const Element& e : mesh.elements) {
      mesh.used.insert(e.begin(), e.end());
      for (size_t k = 0; k < e.size() && e.size() > 1; ++k)
        mesh.edges.insert({std::min(e[k], e[(k + 1) % e.size()]), std::max(e[k], e[(k + 1) % e.size()])});
      if (e.size() == 3) mesh.triangles.push_back(triangle(e));
      mesh.element_bounds.push_back(bounds_of(e));
    }
    for (const auto& edge : mesh.edges) edges_.emplace_back(static_cast<uint32_t>(m), edge);
    mesh_of_element_.resize(mesh_of_element_.size() + mesh.elements.size(), static_cast<uint32_t>(m));
    if (!mesh.used.empty()) mesh.bounds = bounds_of_points({points_[*mesh.used.begin()]});
    for (const uint32_t v : mesh.used) mesh.bounds.add(points_[v]);
    mesh.within = convex_of(scene_.pieces[m].within), mesh.inside_out = convex_of(scene_.pieces[m].inside_out);
  }
  std::vector<Convex<N>> convex_of(const std::vector<Shape>& pieces) const {
    std::vector<Convex<N>> out;
    for (const Shape& piece : pieces) {
      std::vector<Vector<N>> corners;
      for (const Vec3d& p : piece.positions) corners.push_back(as_integers<N>(p, unit_));
      out.emplace_back(corners, piece.triangles);
    }
    return out;
  }
  Bounds<N> bounds_of(const Element& e) const {
    Bounds<N> bounds = bounds_of_points({points_[e[0]]});
    for (const uint32_t v : e) bounds.add(points_[v]);
    return bounds;
  }
  Triangle<N> triangle(const Element& e) const { return {points_[e[0]], points_[e[1]], points_[e[2]]}; }
  const Element& element(uint32_t id) const {
    const Mesh<N>& mesh = meshes_[mesh_of_element_[id]];
    return mesh.elements[id - mesh.first_triangle];
  }

  bool may_touch(uint32_t i, uint32_t j) const {
    const MeshSpec &a = scene_.c.meshes[i], &b = scene_.c.meshes[j];
    if (!(a.solid || b.solid) || (a.motion == MeshMotion::kStatic && b.motion == MeshMotion::kStatic)) return false;
    if ((a.groups & b.collide_mask) == 0 || (b.groups & a.collide_mask) == 0) return false;
    return std::ranges::none_of(scene_.excluded, [&](const auto& pair) {
      return pair == std::array{i, j} || pair == std::array{j, i};
    });
  }

  void judge_pair(uint32_t i, uint32_t j, JudgedSolids& judged) const {
    const uint32_t of_first = count_inside(i, j, judged), of_second = count_inside(j, i, judged);
    const Mesh<N>&first = meshes_[i], &second = meshes_[j];
    const auto add = [&](PairState state, bool is_open = false) {
      judged.pairs.push_back({i, j, state, of_first, of_second, is_open});
    };
    if (touch(first, second)) {
      if (of_first + of_second > 0) return add(PairState::kOverlapping);
      return add(meet_in_more(first, second) ? PairState::kOverlapping : PairState::kTouching,
                 meet_inside_out(first, second));
    }
    if (of_first + of_second == 0) return void(++judged.apart);
    if (of_first == first.used.size() && of_second == 0) return add(PairState::kFirstInside);
    if (of_second == second.used.size() && of_first == 0) return add(PairState::kSecondInside);
    add(PairState::kOverlapping);
  }
  uint32_t count_inside(uint32_t of, uint32_t in, JudgedSolids& judged) const {
    const Mesh<N>& solid = meshes_[in];
    if (!solid.is_solid) return 0;
    uint32_t count = 0;
    for (const uint32_t v : meshes_[of].used) {
      if (!solid.bounds.meets(bounds_of_points({points_[v]}))) continue;
      const Place place = place_in<N>(solid, {points_[v]});
      judged.on += place.is_on, judged.inside_out += place.winding<0, judged.deep += place.winding> 1;
      if (!place.is_inside()) continue;
      ++count;
      judged.inside.push_back(judged_inside(v, in));
    }
    return count;
  }
  JudgedInside judged_inside(uint32_t v, uint32_t in) const {
    const Mesh<N>& solid = meshes_[in];
    JudgedInside found{v, in, 0, {}};
    std::optional<Fraction<N>> least;
    for (uint32_t k = 0; k < solid.triangles.size(); ++k) {
      const Fraction<N> squared = nearest_of_triangle(solid.triangles[k].from(points_[v])).squared;
      if (least && *least < squared) continue;
      if (!least || squared < *least) found.nearest.clear();
      least = squared;
      found.nearest.push_back(solid.first_triangle + k);
    }
    found.depth = length_of(*least);
    return found;
  }
  Nearest<N> nearest(uint32_t vertex, uint32_t id) const {
    const Element& e = element(id);
    return nearest_of_triangle(
        Triangle<N>{points_[e[0]], points_[e[e.size() > 1 ? 1 : 0]], points_[e.back()]}.from(points_[vertex]));
  }
  long double length_of(const Fraction<N>& squared) const { return std::ldexp(root_of(squared), unit_); }

  // Points in common.
  /// One of them is a triangle of a solid.
  bool touch(const Element& e, const Triangle<N>& t) const {
    if (e.size() == 1) return is_on_triangle(points_[e[0]], t);
    return e.size() == 2 ? segment_meets(points_[e[0]], points_[e[1]], t) : triangles_meet(triangle(e), t);
  }
  bool touch(const Mesh<N>& first, const Mesh<N>& second) const {
    return first.is_solid
               ? any_pair(second, first, [&](const Element& e, const Triangle<N>& t) { return touch(e, t); })
               : any_pair(first, second, [&](const Element& e, const Triangle<N>& t) { return touch(e, t); });
  }
  template <class Test>
  bool any_pair(const Mesh<N>& mesh, const Mesh<N>& solid, const Test& test) const {
    for (size_t i = 0; i < mesh.elements.size(); ++i) {
      if (!mesh.element_bounds[i].meets(solid.bounds)) continue;
      for (size_t k = 0; k < solid.triangles.size(); ++k)
        if (mesh.element_bounds[i].meets(solid.element_bounds[k]) && test(mesh.elements[i], solid.triangles[k]))
          return true;
    }
    return false;
  }
  static bool have_in_common(const std::vector<Convex<N>>& first, const std::vector<Convex<N>>& second) {
    return std::ranges::any_of(first, [&](const Convex<N>& a) {
      return std::ranges::any_of(second, [&](const Convex<N>& b) { return have_volume_in_common(a, b); });
    });
  }
  static bool meet_inside_out(const Mesh<N>& first, const Mesh<N>& second) {
    return have_in_common(first.inside_out, second.within) || have_in_common(first.within, second.inside_out) ||
           have_in_common(first.inside_out, second.inside_out);
  }
  /// Whether an edge of the element goes through a triangle.
  bool passes(const Element& e, const Triangle<N>& t) const {
    for (size_t k = 0; k < e.size() && e.size() > 1; ++k)
      if (goes_through(points_[e[k]], points_[e[(k + 1) % e.size()]], t)) return true;
    return false;
  }
  /// A volume, or elements that go through each other.
  bool meet_in_more(const Mesh<N>& first, const Mesh<N>& second) const {
    if (first.is_solid && second.is_solid) return have_in_common(first.within, second.within);
    return any_pair(first.is_solid ? second : first, first.is_solid ? first : second,
                    [&](const Element& e, const Triangle<N>& t) {
                      if (e.size() == 2) return goes_through(points_[e[0]], points_[e[1]], t);
                      return e.size() == 3 && (passes(e, t) || go_through_each_other(triangle(e), t));
                    });
  }

  // Signs.
  ClosestPoints closest_points(const Vector<N>& from, const Nearest<N>& at, bool is_of_second) const {
    const FractionPoint<N> near{from}, far{from, at.place, at.under};
    return is_of_second ? ClosestPoints{far, near} : ClosestPoints{near, far};
  }
  ClosestPoints closest_of_edges(const std::array<uint32_t, 2>& a, const std::array<uint32_t, 2>& b) const {
    std::vector<std::pair<Fraction<N>, ClosestPoints>> found;
    const auto add_ends = [&](const auto& ends, const auto& other, bool is_of_second) {
      for (const uint32_t v : ends) {
        const Nearest<N> at = nearest_of_segment<N>(points_[other[0]] - points_[v], points_[other[1]] - points_[v]);
        found.emplace_back(at.squared, closest_points(points_[v], at, is_of_second));
      }
    };
    add_ends(a, b, false), add_ends(b, a, true);
    const Vector<N> d = points_[a[1]] - points_[a[0]], e = points_[b[1]] - points_[b[0]],
                    across = points_[b[0]] - points_[a[0]], m = cross(d, e);
    if (!is_zero(m)) {
      const N along_d = dot(cross(across, e), m), along_e = dot(cross(across, d), m), whole = dot(m, m),
              height = dot(across, m);
      if (sign(along_d) > 0 && along_d < whole && sign(along_e) > 0 && along_e < whole)
        found.emplace_back(Fraction<N>{N(height * height), whole},
                           ClosestPoints{FractionPoint<N>{points_[a[0]], times(d, along_d), whole},
                                         FractionPoint<N>{points_[b[0]], times(e, along_e), whole}});
    }
    return std::min_element(found.begin(), found.end(),
                            [](const auto& one, const auto& other) { return one.first < other.first; })
        ->second;
  }

  bool have_common_point(const Element& a, const Element& b) const {
    if (b.size() == 3) return touch(a, triangle(b));
    if (a.size() == 3) return touch(b, triangle(a));
    return segments_meet(points_[a[0]], points_[a.back()], points_[b[0]], points_[b.back()]);
  }
  /// A vertex alone meets nothing.
  bool meets(const Feature& feature, const Mesh<N>& mesh) const {
    if (feature.vertices.size() == 1) return false;
    const Bounds<N> bounds = bounds_of(feature.vertices);
    for (size_t k = 0; k < mesh.elements.size(); ++k)
      if (bounds.meets(mesh.element_bounds[k]) && have_common_point(feature.vertices, mesh.elements[k])) return true;
    return false;
  }
  JudgedSign sign_of(const Feature& first, const Feature& second, const ClosestPoints& closest) const {
    const Mesh<N>&of_first = meshes_[first.mesh], &of_second = meshes_[second.mesh];
    const bool has_solid = first.mesh != second.mesh && (of_first.is_solid || of_second.is_solid);
    JudgedSign judged{{first.mesh, second.mesh}, has_solid, false, 1, apart(closest)};
    if (!has_solid) return judged;
    judged.meets = meets(first, of_second) || meets(second, of_first);
    if ((of_second.is_solid && place_in(of_second, closest[0]).is_inside()) ||
        (of_first.is_solid && place_in(of_first, closest[1]).is_inside()))
      judged.sign = -1;
    return judged;
  }
  std::array<long double, 3> apart(const ClosestPoints& at) const {
    std::array<long double, 3> out;
    for (size_t k = 0; k < 3; ++k) {
      const N over = at[0].origin[k] * at[0].under * at[1].under + at[0].place[k] * at[1].under -
                     at[1].origin[k] * at[0].under * at[1].under - at[1].place[k] * at[0].under;
      const N under = at[0].under * at[1].under;
      out[k] = std::ldexp(rounded(big(over)) / rounded(big(under)), unit_);
    }
    return out;
  }

  const SolidsScene scene_;
  int unit_;  ///< exponent
  std::vector<Vector<N>> points_;
  std::vector<Mesh<N>> meshes_;
  std::vector<uint32_t> mesh_of_vertex_, mesh_of_element_;
  std::vector<std::pair<uint32_t, std::array<uint32_t, 2>>> edges_;  ///< by id: the mesh and both ends
};

/// Products of differences fit 128 bits where meshes are small integers in units of the lowest bit.
bool is_small(const SolidsScene& scene) {
  constexpr double kLongest = 16;
  const double unit = std::ldexp(1.0, lowest_bit_of(scene));
  return std::ranges::all_of(scene.c.end, [&](const Positions& mesh) {
    for (size_t k = 0; k < 3 && !mesh.empty(); ++k) {
      const auto [least, greatest] = std::ranges::minmax(mesh, {}, [&](const Vec3d& p) { return p[k]; });
      if (!(greatest[k] - least[k] <= kLongest * unit) || std::abs(greatest[k]) > 0x1p60 * unit) return false;
    }
    return true;
  });
}

}  // namespace

std::unique_ptr<SolidsJudge> make_solids_judge(const SolidsScene& scene) {
  if (is_small(scene)) return std::make_unique<Judge<Int128>>(scene);
  return std::make_unique<Judge<mpz_class>>(scene);
}

}  // namespace collided::test
