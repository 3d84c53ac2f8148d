#include "tests/gpu/solids/solids_judge.hpp"

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "tests/gpu/solids/exact_meetings.hpp"

namespace collided::test {
namespace {

/// The exponent of the lowest bit of a number that is not 0.
int lowest_bit(double x) {
  int exponent;
  auto bits = static_cast<int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  exponent -= 53;
  for (; bits % 2 == 0; bits /= 2) ++exponent;
  return exponent;
}
/// Of all coordinates; 0 if all are 0.
int lowest_bit(const SolidsScene& scene) {
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
/// In units of 2^exponent.
template <class N>
Vector<N> as_integers(const Vec3d& p, int exponent) {
  Vector<N> out;
  for (size_t k = 0; k < 3; ++k) {
    int of_p;
    out[k] = static_cast<int64_t>(std::ldexp(std::frexp(p[k], &of_p), 53));
    const int shift = p[k] == 0 ? 0 : of_p - 53 - exponent;
    if (shift > 0) out[k] <<= static_cast<unsigned>(shift);
    if (shift < 0) out[k] >>= static_cast<unsigned>(-shift);  // bits that are 0
  }
  return out;
}

/// x, within 2^-63 of its size.
long double rounded(const mpz_class& x) {
  const size_t bits = mpz_sizeinbase(x.get_mpz_t(), 2);
  if (bits <= 64) return static_cast<long double>(mpz_get_ui(x.get_mpz_t())) * sgn(x);
  const mpz_class top = abs(x) >> (bits - 64);
  return std::ldexp(static_cast<long double>(mpz_get_ui(top.get_mpz_t())), static_cast<int>(bits - 64)) * sgn(x);
}
template <class N>
long double root_of(const Fraction<N>& squared) {
  const mpz_class over = big(squared.over), under = big(squared.under);
  const auto bits = [](const mpz_class& x) { return static_cast<int>(mpz_sizeinbase(x.get_mpz_t(), 2)); };
  const int half = std::max(0, 70 + (bits(under) - bits(over)) / 2);
  const mpz_class shifted = (over << static_cast<unsigned>(2 * half)) / under;
  return std::ldexp(rounded(sqrt(shifted)), -half);
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
Bounds<N> bounds_of(std::initializer_list<Vector<N>> points) {
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
  std::vector<Triangle<N>> triangles;
  uint32_t first_triangle = 0;  ///< scene-wide id
  std::set<uint32_t> used;      ///< vertices, scene-wide
  std::set<std::array<uint32_t, 2>> edges;
  std::vector<Convex<N>> within, inside_out;
  Bounds<N> bounds;
};

/// Where a point is with regard to a solid.
struct Place {
  bool is_on = false;
  int winding = 0;

  bool is_inside() const { return !is_on && winding > 0; }
  bool is_outside() const { return !is_on && winding <= 0; }
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
  explicit Judge(const SolidsScene& scene) : scene_(scene), unit_(lowest_bit(scene)) {
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
    return sign_of({{ids[0]}, mesh}, {element(ids[1]), other}, {{first, second}});
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
    }
    for (const auto& edge : mesh.edges) edges_.emplace_back(static_cast<uint32_t>(m), edge);
    mesh_of_element_.resize(mesh_of_element_.size() + mesh.elements.size(), static_cast<uint32_t>(m));
    if (!mesh.used.empty()) mesh.bounds = bounds_of({points_[*mesh.used.begin()]});
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
      if (!solid.bounds.meets(bounds_of({points_[v]}))) continue;
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
    return std::ranges::any_of(mesh.elements, [&](const Element& e) {
      Bounds<N> bounds = bounds_of({points_[e[0]]});
      for (const uint32_t v : e) bounds.add(points_[v]);
      return bounds.meets(solid.bounds) && std::ranges::any_of(solid.triangles, [&](const Triangle<N>& t) {
               return bounds.meets(bounds_of({t.a, t.b, t.c})) && test(e, t);
             });
    });
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
  /// All that an end has a part in, or that are within both.
  std::vector<ClosestPoints> closest_of_edges(const std::array<uint32_t, 2>& a,
                                              const std::array<uint32_t, 2>& b) const {
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
    Fraction<N> least = found.front().first;
    for (const auto& one : found) least = std::min(least, one.first);
    std::vector<ClosestPoints> closest;
    for (const auto& [squared, points] : found)
      if (squared == least) closest.push_back(points);
    return closest;
  }

  enum class Relation { kApart, kTouches, kGoesThrough };
  /// Of a feature and the surface of a mesh.
  Relation relation(const Element& feature, const Mesh<N>& mesh) const {
    Relation found = Relation::kApart;
    const auto keep = [&](bool touches, bool goes_through) {
      if (goes_through) found = Relation::kGoesThrough;
      if (touches && !goes_through && found == Relation::kApart) found = Relation::kTouches;
    };
    for (const Triangle<N>& t : mesh.triangles) keep(touch(feature, t), passes(feature, t));
    if (feature.size() == 3)
      for (const auto& edge : mesh.edges)
        keep(segment_meets(points_[edge[0]], points_[edge[1]], triangle(feature)),
             goes_through(points_[edge[0]], points_[edge[1]], triangle(feature)));
    return found;
  }
  /// Whether an edge of the feature goes through a triangle.
  bool passes(const Element& e, const Triangle<N>& t) const {
    for (size_t k = 0; k < e.size() && e.size() > 1; ++k)
      if (goes_through(points_[e[k]], points_[e[(k + 1) % e.size()]], t)) return true;
    return false;
  }
  /// Of a feature that only touches a solid: whether some of its points, of many, are inside and some outside.
  bool is_on_both_sides(const Element& e, const Mesh<N>& solid) const {
    constexpr int kSteps = 4;
    bool is_inside = false, is_outside = false;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const Vector<N> from = points_[e[0]], u = points_[e[e.size() > 1 ? 1 : 0]] - from, v = points_[e.back()] - from;
        const Place place = place_in<N>(solid, {from, times(u, N(i)) + times(v, N(j)), N(kSteps)});
        is_inside = is_inside || place.is_inside(), is_outside = is_outside || place.is_outside();
      }
    return is_inside && is_outside;
  }
  JudgedSign sign_of(const Feature& first, const Feature& second, const std::vector<ClosestPoints>& closest) const {
    JudgedSign judged{0, false, false, apart(closest.front())};
    const Mesh<N>&of_first = meshes_[first.mesh], &of_second = meshes_[second.mesh];
    if (first.mesh == second.mesh || !(of_first.is_solid || of_second.is_solid)) return judged;
    const Relation one = relation(first.vertices, of_second), other = relation(second.vertices, of_first);
    judged.is_tied = one == Relation::kTouches || other == Relation::kTouches;
    if (one == Relation::kGoesThrough || other == Relation::kGoesThrough) return judged;
    if (judged.is_tied && ((of_second.is_solid && is_on_both_sides(first.vertices, of_second)) ||
                           (of_first.is_solid && is_on_both_sides(second.vertices, of_first))))
      return judged;
    const auto sign_at = [&](const ClosestPoints& at) {
      return (of_second.is_solid && place_in(of_second, at[0]).is_inside()) ||
                     (of_first.is_solid && place_in(of_first, at[1]).is_inside())
                 ? -1
                 : 1;
    };
    judged.sign = sign_at(closest.front());
    judged.is_open = std::ranges::any_of(closest, [&](const ClosestPoints& at) { return sign_at(at) != judged.sign; });
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
  constexpr double kLongest = 10;
  const double unit = std::ldexp(1.0, lowest_bit(scene));
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
