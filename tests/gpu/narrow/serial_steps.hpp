#pragma once
// Whole steps of gpu/narrow/shortening.hpp, one pair after the other over a list of all pairs: a reference for tests.
// It has no broad phase but boxes, and looks at pairs in any order that is asked for.

#include <cmath>
#include <set>
#include <vector>

#include "gpu/narrow/hulls_apart.hpp"
#include "gpu/positions/blend.hpp"
#include "gpu/step/blocking_pairs.hpp"
#include "tests/support/families/query_families_shapes.hpp"

namespace collided::test {

/// Meshes as a list of vertices. A triangle (a, b, b) is a loose edge, (a, a, a) a loose point.
struct StepScene {
  std::vector<Vec3d> positions;
  std::vector<uint32_t> mesh;  ///< of each vertex
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<bool> is_static;  ///< of each mesh

  /// Adds a mesh; its triangles count its own vertices.
  void add(const std::vector<Vec3d>& vertices, const std::vector<std::array<uint32_t, 3>>& faces, bool fixed = false) {
    const uint32_t first = static_cast<uint32_t>(positions.size());
    for (const Vec3d& p : vertices) positions.push_back(p), mesh.push_back(static_cast<uint32_t>(is_static.size()));
    for (const auto& f : faces) triangles.push_back({first + f[0], first + f[1], first + f[2]});
    is_static.push_back(fixed);
  }
};

/// What has a fraction of its own.
enum class FractionOf { kVertex, kMesh, kScene };

struct StepPair {
  QueryKind kind;
  std::array<uint32_t, 4> v;
  bool may_fail;  ///< no plane parts the hulls; else what follows is not set
  double start;   ///< f
  PairFloors floors;
};

struct StepResult {
  std::vector<Vec3d> y;
  std::vector<double> fractions;  ///< of each vertex
  uint32_t rounds = 0;            ///< in which a pair failed
  std::vector<StepPair> pairs;    ///< those whose boxes come within reach
};

template <class Real>
class SerialSteps {
 public:
  SerialSteps(const StepScene& scene, double min_separation, FractionOf fraction_of, uint64_t order = 0)
      : scene_(scene), min_separation_(min_separation) {
    for (uint32_t v = 0; v < scene.positions.size(); ++v)
      group_.push_back(fraction_of == FractionOf::kVertex ? v : fraction_of == FractionOf::kMesh ? scene.mesh[v] : 0);
    list_edges();
    list_neighbours();
    list_pairs();
    Random random(order);
    if (order != 0)
      for (size_t i = all_.size(); i > 1; --i) std::swap(all_[i - 1], all_[random.next() % i]);
  }

  /// Begins with the proposals of this round, as if those before it had not been enough.
  void begin_with(uint32_t round) { first_round_ = round; }
  /// Goes from x towards p. Both have to be what Real holds.
  StepResult advance(const std::vector<Vec3d>& x, const std::vector<Vec3d>& p) {
    x_ = &x, p_ = &p;
    StepResult result;
    result.y = p;
    result.pairs = prepared();
    std::vector<double> of_group(x.size(), 1);
    std::vector<size_t> work;
    for (size_t i = 0; i < result.pairs.size(); ++i)
      if (result.pairs[i].may_fail) work.push_back(i);
    for (;; ++result.rounds) {
      std::vector<double> share(x.size(), 1);
      std::vector<size_t> failed;
      const Shortening how = shortening_of(first_round_ + result.rounds);
      const std::vector<Vec3<Real>> start = all_real(x), end = all_real(result.y);
      for (const size_t i : work)
        if (!judge(result.pairs[i], start, end, how, share)) failed.push_back(i);
      if (failed.empty()) break;
      if (how == Shortening::kIslands) stand_islands(result.pairs, failed, share);
      const std::vector<bool> has_changed = shorten(share, of_group, result.y);
      work = to_look_at(result.pairs, failed, has_changed);
    }
    for (const uint32_t group : group_) result.fractions.push_back(of_group[group]);
    return result;
  }

  double f(const StepPair& pair, const std::vector<Vec3d>& at) const {
    const FeaturePoints<Real> points = points_of(pair, at, at);
    return with_kind(pair, [&](auto kind) { return certified_distance<decltype(kind)>(points.start); }).value;
  }
  Query query_of(const StepPair& pair, const std::vector<Vec3d>& from, const std::vector<Vec3d>& to) const {
    Query query{pair.kind, {}};
    for (size_t i = 0; i < 4; ++i) query.p[i] = from[pair.v[i]], query.p[i + 4] = to[pair.v[i]];
    return query;
  }

 private:
  template <class Use>
  static auto with_kind(const StepPair& pair, const Use& use) {
    return pair.kind == QueryKind::kEdgeEdge ? use(EdgeEdge{}) : use(VertexTriangle{});
  }
  void list_edges() {
    for (const auto& t : scene_.triangles)
      for (const auto& [a, b] : {std::pair{t[0], t[1]}, std::pair{t[1], t[2]}, std::pair{t[2], t[0]}})
        if (a != b) edges_.insert({std::min(a, b), std::max(a, b)});
  }
  void list_neighbours() {
    for (uint32_t v = 0; v < scene_.positions.size(); ++v) {
      neighbour_begin_.push_back(static_cast<uint32_t>(neighbours_.size()));
      for (uint32_t w = 0; w < scene_.positions.size(); ++w)
        if (edges_.count(std::minmax(v, w)) > 0) neighbours_.push_back(w);
    }
    neighbour_begin_.push_back(static_cast<uint32_t>(neighbours_.size()));
  }
  void add_pair(QueryKind kind, const std::array<uint32_t, 4>& v) {
    const size_t first = first_feature(kind);
    for (size_t i = 0; i < first; ++i)
      for (size_t j = first; j < 4; ++j)
        if (v[i] == v[j]) return;
    if (is_static(v[0]) && is_static(v[3])) return;
    all_.push_back({kind, v, false, 0, {}});
  }
  void list_pairs() {
    for (uint32_t v = 0; v < scene_.positions.size(); ++v)
      for (const auto& t : scene_.triangles) add_pair(QueryKind::kVertexTriangle, {v, t[0], t[1], t[2]});
    for (auto a = edges_.begin(); a != edges_.end(); ++a)
      for (auto b = std::next(a); b != edges_.end(); ++b)
        add_pair(QueryKind::kEdgeEdge, {a->first, a->second, b->first, b->second});
  }
  bool is_static(uint32_t vertex) const { return scene_.is_static[scene_.mesh[vertex]]; }
  bool is_joined(const StepPair& pair) const {
    const size_t first = first_feature(pair.kind);
    for (size_t i = 0; i < first; ++i)
      for (size_t j = first; j < 4; ++j)
        if (edges_.count(std::minmax(pair.v[i], pair.v[j])) > 0) return true;
    return false;
  }
  static Vec3<Real> real(const Vec3d& p) {
    return {static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2])};
  }
  static FeaturePoints<Real> points_of(const StepPair& pair, const std::vector<Vec3d>& from,
                                       const std::vector<Vec3d>& to) {
    FeaturePoints<Real> points;
    for (size_t i = 0; i < 4; ++i) points.start[i] = real(from[pair.v[i]]), points.end[i] = real(to[pair.v[i]]);
    return points;
  }
  static std::vector<Vec3<Real>> all_real(const std::vector<Vec3d>& positions) {
    std::vector<Vec3<Real>> all;
    for (const Vec3d& p : positions) all.push_back(real(p));
    return all;
  }
  /// True if the boxes of both features' ways are within `reach`.
  bool boxes_meet(const StepPair& pair, double reach) const {
    const size_t first = first_feature(pair.kind);
    for (size_t k = 0; k < 3; ++k) {
      double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
      for (size_t i = 0; i < 4; ++i)
        for (const auto* positions : {x_, p_}) {
          const double c = (*positions)[pair.v[i]][k];
          low[i >= first] = std::min(low[i >= first], c), high[i >= first] = std::max(high[i >= first], c);
        }
      if (low[0] - high[1] > reach * 1.001 || low[1] - high[0] > reach * 1.001) return false;
    }
    return true;
  }
  double scene_extent() const {
    double extent = 0;
    for (size_t k = 0; k < 3; ++k) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (const Vec3d& x : *x_) low = std::min(low, x[k]), high = std::max(high, x[k]);
      extent = std::max(extent, high - low);
    }
    return extent;
  }
  std::vector<StepPair> prepared() {
    rules_ = FloorRules::of(min_separation_, scene_extent());
    std::vector<StepPair> pairs;
    std::vector<StartDistance> starts;
    std::vector<double> clearance(x_->size(), HUGE_VAL);
    for (StepPair pair : all_) {
      if (!boxes_meet(pair, rules_.reach())) continue;
      const FeaturePoints<Real> way = points_of(pair, *x_, *p_);
      const double noise = PositionNoise<Real>::kOfFloor * largest_coordinate(way);
      StartDistance start{};
      with_kind(pair, [&](auto kind) {
        using Kind = decltype(kind);
        pair.may_fail = !hulls_are_apart<Kind>(way, rules_.reach() + noise);
        if (pair.may_fail) start = start_distance<Kind>(way, rules_);
      });
      pair.start = start.value;
      pairs.push_back(pair), starts.push_back(start);
      if (!pair.may_fail || start.value >= rules_.reach() || is_joined(pair)) continue;
      for (const uint32_t v : pair.v)
        if (!is_static(v)) clearance[v] = std::min(clearance[v], start.value);
    }
    for (size_t n = 0; n < pairs.size(); ++n) {
      if (!pairs[n].may_fail) continue;
      double least = HUGE_VAL;
      for (const uint32_t v : pairs[n].v) least = std::min(least, clearance[v]);
      pairs[n].floors = rules_.floors_of<Real>(starts[n], least);
    }
    return pairs;
  }
  /// Returns true if the pair may go its way; else its proposals go to `share`.
  bool judge(const StepPair& pair, const std::vector<Vec3<Real>>& start, const std::vector<Vec3<Real>>& end,
             Shortening how, std::vector<double>& share) const {
    return with_kind(pair, [&](auto kind) {
      using Kind = decltype(kind);
      const PairStars<Kind, Real> stars{
          {{pair.v[0], pair.v[1], pair.v[2], pair.v[3]}},
          {{neighbour_begin_.data(), neighbour_begin_.size()}, {neighbours_.data(), neighbours_.size()}},
          start.data(),
          end.data()};
      if (is_way_free(stars, pair.floors)) return true;
      const FeaturePoints<Real> way = collided::points_of(stars.s, start.data(), end.data());
      const Shares shares = shares_of_failed<Kind>(way, pair.floors, how);
      for (size_t i = 0; i < 4; ++i) {
        double& least = share[group_[pair.v[i]]];
        least = std::min(least, shares.of[i]);
      }
      return false;
    });
  }
  bool moves(uint32_t vertex) const { return (*x_)[vertex] != (*p_)[vertex]; }
  /// What failing pairs are connected to, through what moves, stands.
  void stand_islands(const std::vector<StepPair>& pairs, const std::vector<size_t>& failed,
                     std::vector<double>& share) const {
    std::set<uint32_t> groups;
    const auto touches = [&](const StepPair& pair) {
      for (const uint32_t v : pair.v)
        if (moves(v) && groups.count(group_[v]) > 0) return true;
      return false;
    };
    const auto take = [&](const StepPair& pair) {
      for (const uint32_t v : pair.v)
        if (moves(v)) groups.insert(group_[v]);
    };
    for (const size_t i : failed) take(pairs[i]);
    for (size_t before = 0; before != groups.size();) {
      before = groups.size();
      for (const StepPair& pair : pairs)
        if (pair.may_fail && touches(pair)) take(pair);
    }
    for (const uint32_t group : groups) share[group] = 0;
  }
  std::vector<bool> shorten(const std::vector<double>& share, std::vector<double>& of_group,
                            std::vector<Vec3d>& y) const {
    std::vector<bool> has_changed(y.size(), false);
    for (size_t g = 0; g < of_group.size(); ++g) {
      const double next = share[g] < 1 ? shortened(of_group[g], share[g]) : of_group[g];
      has_changed[g] = next != of_group[g];
      of_group[g] = next;
    }
    for (size_t v = 0; v < y.size(); ++v)
      for (size_t k = 0; k < 3; ++k)
        y[v][k] = blend(static_cast<Real>((*x_)[v][k]), static_cast<Real>((*p_)[v][k]), of_group[group_[v]]);
    return has_changed;
  }
  std::vector<size_t> to_look_at(const std::vector<StepPair>& pairs, const std::vector<size_t>& failed,
                                 const std::vector<bool>& has_changed) const {
    std::vector<bool> looks(pairs.size(), false);
    for (const size_t i : failed) looks[i] = true;
    std::vector<size_t> work;
    for (size_t i = 0; i < pairs.size(); ++i) {
      for (const uint32_t v : pairs[i].v) {
        looks[i] = looks[i] || has_changed[group_[v]];
        for (uint32_t n = neighbour_begin_[v]; pairs[i].floors.is_tiny && n < neighbour_begin_[v + 1]; ++n)
          looks[i] = looks[i] || has_changed[group_[neighbours_[n]]];
      }
      if (looks[i] && pairs[i].may_fail) work.push_back(i);
    }
    return work;
  }

  StepScene scene_;
  double min_separation_;
  FloorRules rules_{};
  uint32_t first_round_ = 0;
  std::vector<uint32_t> group_;
  std::set<std::pair<uint32_t, uint32_t>> edges_;
  std::vector<uint32_t> neighbour_begin_, neighbours_;  ///< of all vertices, as VertexRings
  std::vector<StepPair> all_;
  const std::vector<Vec3d>*x_ = nullptr, *p_ = nullptr;
};

}  // namespace collided::test
