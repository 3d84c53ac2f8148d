#include "tests/support/brute_force.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <sstream>

namespace collided::test {
namespace {

struct Box {
  Vec3d lo{}, hi{};
};

enum class Reach { kNo, kMay, kMust };

// One side of the sweep: boxes sorted by their lower end on the sweep axis.
struct Side {
  std::vector<Box> boxes;
  std::vector<uint32_t> ids;
};

Box empty_box() {
  constexpr double inf = std::numeric_limits<double>::infinity();
  return {{inf, inf, inf}, {-inf, -inf, -inf}};
}

void extend(Box& box, const Vec3d& p) {
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = std::min(box.lo[k], p[k]);
    box.hi[k] = std::max(box.hi[k], p[k]);
  }
}

Positions joined(const std::vector<Positions>& parts) {
  Positions all;
  for (const Positions& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// The exact value of b - a is sum + error (Knuth's two-sum); rounding is monotone, so only a tie needs the error.
bool difference_at_most(double b, double a, double limit) {
  const double sum = b - a;
  if (sum != limit) return sum < limit;
  const double virtual_a = b - sum;
  const double error = (b - (sum + virtual_a)) + (virtual_a - a);
  return error <= 0;
}

struct Gap {
  double exact;  ///< the thickness
  double slack;  ///< plus what outward rounding may add

  Reach reach(const Box& a, const Box& b) const {
    bool must = true;
    for (int k = 0; k < 3; ++k) {
      if (b.lo[k] - a.hi[k] > slack || a.lo[k] - b.hi[k] > slack) return Reach::kNo;
      must = must && difference_at_most(b.lo[k], a.hi[k], exact) && difference_at_most(a.lo[k], b.hi[k], exact);
    }
    return must ? Reach::kMust : Reach::kMay;
  }
};

double slack_of(const Positions& positions, Scalar scalar, double thickness) {
  if (thickness == 0) return 0;
  double largest = thickness;
  for (const Vec3d& p : positions)
    for (double x : p) largest = std::max(largest, std::abs(x));
  const double epsilon = scalar == Scalar::kF32 ? std::numeric_limits<float>::epsilon() : 2.3e-16;
  return thickness * (1 + 1e-5) + 4 * epsilon * largest;
}

Side sorted_side(const std::vector<Box>& boxes, std::vector<uint32_t> ids, int axis) {
  std::sort(ids.begin(), ids.end(), [&](uint32_t a, uint32_t b) { return boxes[a].lo[axis] < boxes[b].lo[axis]; });
  Side side{{}, std::move(ids)};
  for (uint32_t id : side.ids) side.boxes.push_back(boxes[id]);
  return side;
}

// Calls visit(a, b, reach) once for every pair (a of `left`, b of `right`) within reach whose b starts at or after a.
// `strict` leaves out pairs that start together, so that the mirrored sweep does not see them twice.
template <class Visit>
void sweep(const Side& left, const Side& right, int axis, const Gap& gap, bool strict, Visit&& visit) {
  size_t from = 0;
  for (size_t i = 0; i < left.ids.size(); ++i) {
    const Box& a = left.boxes[i];
    const double low = a.lo[axis];
    while (from < right.ids.size() && (strict ? right.boxes[from].lo[axis] <= low : right.boxes[from].lo[axis] < low))
      ++from;
    for (size_t j = from; j < right.ids.size() && right.boxes[j].lo[axis] - a.hi[axis] <= gap.slack; ++j) {
      const Reach reach = gap.reach(a, right.boxes[j]);
      if (reach != Reach::kNo) visit(left.ids[i], right.ids[j], reach);
    }
  }
}

template <class Visit>
void sweep_self(const Side& side, int axis, const Gap& gap, Visit&& visit) {
  for (size_t i = 0; i < side.ids.size(); ++i) {
    const Box& a = side.boxes[i];
    for (size_t j = i + 1; j < side.ids.size() && side.boxes[j].lo[axis] - a.hi[axis] <= gap.slack; ++j) {
      const Reach reach = gap.reach(a, side.boxes[j]);
      if (reach != Reach::kNo) visit(side.ids[i], side.ids[j], reach);
    }
  }
}

class Finder {
 public:
  Finder(const Case& c, Mode mode, Scalar scalar, double thickness)
      : case_(c), features_(features_of(c)), tested_(features_) {
    const Positions start = joined(c.start), end = joined(c.end);
    for (size_t v = 0; v < end.size(); ++v) {
      Box box = empty_box();
      extend(box, end[v]);
      if (mode == Mode::kCcd) extend(box, start[v]);
      vertices_.push_back(box);
    }
    gap_ = {thickness, std::max(slack_of(end, scalar, thickness), slack_of(start, scalar, thickness))};
    axis_ = longest_axis();
  }

  PairSet vertex_triangle() const {
    const Side vertices = sorted_side(vertices_, used_vertices(), axis_);
    const Side triangles = side_of(features_.triangles);
    PairSet pairs;
    const auto add_pair = [&](uint32_t v, uint32_t t, Reach reach) {
      const auto& corners = features_.triangles[t];
      const bool corner = v == corners[0] || v == corners[1] || v == corners[2];
      if (!corner && tested_.has(v, t) && may_touch(v, corners[0])) add(pairs, key_of(v, t), reach);
    };
    sweep(vertices, triangles, axis_, gap_, false, add_pair);
    sweep(triangles, vertices, axis_, gap_, true, [&](uint32_t t, uint32_t v, Reach r) { add_pair(v, t, r); });
    return sorted(std::move(pairs));
  }

  PairSet edge_edge() const {
    PairSet pairs;
    sweep_self(side_of(features_.edges), axis_, gap_, [&](uint32_t i, uint32_t j, Reach reach) {
      const auto &e = features_.edges[i], &f = features_.edges[j];
      const bool shared = e[0] == f[0] || e[0] == f[1] || e[1] == f[0] || e[1] == f[1];
      if (!shared && may_touch(e[0], f[0])) add(pairs, key_of(std::min(i, j), std::max(i, j)), reach);
    });
    return sorted(std::move(pairs));
  }

 private:
  int longest_axis() const {
    Box all = empty_box();
    for (const Box& box : vertices_) {
      extend(all, box.lo);
      extend(all, box.hi);
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (all.hi[k] - all.lo[k] > all.hi[axis] - all.lo[axis]) axis = k;
    return axis;
  }

  template <class Elements>
  Side side_of(const Elements& elements) const {
    std::vector<Box> boxes;
    for (const auto& element : elements) {
      Box box = empty_box();
      for (uint32_t v : element) {
        extend(box, vertices_[v].lo);
        extend(box, vertices_[v].hi);
      }
      boxes.push_back(box);
    }
    std::vector<uint32_t> ids(boxes.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return sorted_side(boxes, std::move(ids), axis_);
  }

  // A vertex of no element is no feature.
  std::vector<uint32_t> used_vertices() const {
    std::vector<uint32_t> ids;
    for (uint32_t v = 0; v < vertices_.size(); ++v)
      if (tested_.is_used(v)) ids.push_back(v);
    return ids;
  }

  bool may_touch(uint32_t v, uint32_t w) const {
    const uint32_t i = features_.mesh_of_vertex[v], j = features_.mesh_of_vertex[w];
    const MeshSpec &a = case_.meshes[i], &b = case_.meshes[j];
    if (a.motion == MeshMotion::kStatic && b.motion == MeshMotion::kStatic) return false;
    if (i == j && !a.self_contacts) return false;
    return (a.groups & b.collide_mask) && (b.groups & a.collide_mask);
  }

  static void add(PairSet& pairs, PairKey key, Reach reach) {
    pairs.may.push_back(key);
    if (reach == Reach::kMust) pairs.must.push_back(key);
  }

  static PairSet sorted(PairSet pairs) {
    std::sort(pairs.must.begin(), pairs.must.end());
    std::sort(pairs.may.begin(), pairs.may.end());
    return pairs;
  }

  const Case& case_;
  Features features_;
  VertexTrianglePairs tested_;
  std::vector<Box> vertices_;
  Gap gap_{};
  int axis_ = 0;
};

void report(std::ostringstream& out, const char* what, const std::vector<PairKey>& keys) {
  if (keys.empty()) return;
  out << keys.size() << " " << what << ":";
  for (size_t i = 0; i < std::min<size_t>(keys.size(), 5); ++i)
    out << " (" << (keys[i] >> 32) << ", " << static_cast<uint32_t>(keys[i]) << ")";
  out << "; ";
}

}  // namespace

VertexTrianglePairs::VertexTrianglePairs(const Features& features) : features_(features) {
  using Ends = std::set<uint32_t>;
  std::set<Ends> edges;
  for (uint32_t i = 0; i < features.triangles.size(); ++i) {
    const auto [a, b, c] = features.triangles[i];
    const ElementKind kind = features.kinds[i];
    if (kind == ElementKind::kPoint && !used_.contains(a)) lone_points_[a] = i;
    if (kind == ElementKind::kEdge && edges.insert(Ends{a, b}).second) lone_edges_.insert(i);
    if (kind == ElementKind::kTriangle) edges.insert({Ends{a, b}, Ends{b, c}, Ends{c, a}});
    used_.insert({a, b, c});
  }
}

// Elements of a mesh come in the order of their kinds, and meshes share no vertices.
bool VertexTrianglePairs::has(uint32_t vertex, uint32_t element) const {
  if (features_.kinds[element] == ElementKind::kTriangle) return is_used(vertex);
  const auto own = lone_points_.find(vertex);
  if (own == lone_points_.end()) return false;
  if (features_.kinds[element] == ElementKind::kEdge) return lone_edges_.contains(element);
  const auto other = lone_points_.find(features_.triangles[element][0]);
  return other != lone_points_.end() && other->second == element && own->second < element;
}

Features features_of(const Case& c) {
  Features f;
  std::vector<PairKey> edges;
  for (uint32_t m = 0; m < c.meshes.size(); ++m) {
    const auto offset = static_cast<uint32_t>(f.mesh_of_vertex.size());
    f.mesh_of_vertex.insert(f.mesh_of_vertex.end(), c.meshes[m].vertex_count, m);
    for (const auto& t : c.meshes[m].triangles) {
      f.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
      for (int k = 0; k < 3; ++k) {
        const uint32_t a = t[k] + offset, b = t[(k + 1) % 3] + offset;
        edges.push_back(key_of(std::min(a, b), std::max(a, b)));
      }
    }
    for (const auto& [a, b] : c.meshes[m].edges) {
      f.triangles.push_back({a + offset, b + offset, b + offset});
      edges.push_back(key_of(std::min(a, b) + offset, std::max(a, b) + offset));
    }
    for (const uint32_t p : c.meshes[m].points) f.triangles.push_back({p + offset, p + offset, p + offset});
    f.kinds.insert(f.kinds.end(), c.meshes[m].triangles.size(), ElementKind::kTriangle);
    f.kinds.insert(f.kinds.end(), c.meshes[m].edges.size(), ElementKind::kEdge);
    f.kinds.insert(f.kinds.end(), c.meshes[m].points.size(), ElementKind::kPoint);
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (PairKey e : edges) f.edges.push_back({static_cast<uint32_t>(e >> 32), static_cast<uint32_t>(e)});
  return f;
}

ExpectedPairs brute_force(const Case& c, Mode mode, Scalar scalar, double thickness) {
  const Finder finder(c, mode, scalar, thickness);
  return {finder.vertex_triangle(), finder.edge_edge()};
}

std::string compare(std::span<const std::array<uint32_t, 2>> found, const PairSet& expected) {
  std::vector<PairKey> keys, missing, extra, repeated;
  for (const auto& pair : found) keys.push_back(key_of(pair[0], pair[1]));
  std::ostringstream out;
  if (!std::is_sorted(keys.begin(), keys.end())) {
    out << "not in canonical order; ";
    std::sort(keys.begin(), keys.end());
  }
  for (size_t i = 1; i < keys.size(); ++i)
    if (keys[i] == keys[i - 1]) repeated.push_back(keys[i]);
  std::set_difference(expected.must.begin(), expected.must.end(), keys.begin(), keys.end(),
                      std::back_inserter(missing));
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  std::set_difference(keys.begin(), keys.end(), expected.may.begin(), expected.may.end(), std::back_inserter(extra));
  report(out, "repeated", repeated);
  report(out, "missing", missing);
  report(out, "too many", extra);
  return out.str();
}

}  // namespace collided::test
