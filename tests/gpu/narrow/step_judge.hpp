#pragma once
// Judges steps of serial_steps.hpp in integer arithmetic.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/gpu/narrow/serial_steps.hpp"

namespace collided::test {

/// What the judge found, and how much it looked at.
struct Findings {
  size_t steps = 0, ends = 0, ways = 0, passages = 0, tiny = 0;
  size_t ends_below = 0, ways_below = 0, passed = 0, crossed = 0;
  uint32_t most_rounds = 0;
  double share = 0;  ///< sum over steps

  void expect_none() const {
    EXPECT_EQ(ends_below, 0u);
    EXPECT_EQ(ways_below, 0u);
    EXPECT_EQ(passed, 0u);
    EXPECT_EQ(crossed, 0u);
  }
  void print(const char* what) const {
    std::printf("%s: %zu steps, %zu ends, %zu ways, %zu passages, %zu tiny, at most %u rounds, mean share %.4f\n", what,
                steps, ends, ways, passages, tiny, most_rounds, steps > 0 ? share / static_cast<double>(steps) : 0);
  }
};

/// The share of the motion that was gone, by the lengths of the vertices' ways.
inline double share_of(const std::vector<Vec3d>& x, const std::vector<Vec3d>& p, const StepResult& result) {
  double gone = 0, all = 0;
  for (size_t v = 0; v < x.size(); ++v) {
    const Vec3d way = minus(p[v], x[v]);
    const double length = std::hypot(way[0], way[1], way[2]);
    all += length, gone += result.fractions[v] * length;
  }
  return all > 0 ? gone / all : 1;
}

/// Some of them, at random, if they are too many.
template <class T>
void thin_out(std::vector<T>& all, size_t most, Random& random) {
  for (size_t i = 0; i < most && i < all.size(); ++i) std::swap(all[i], all[i + random.next() % (all.size() - i)]);
  if (all.size() > most) all.resize(most);
}

inline bool is_below(const Query& query, double distance) {
  const Points end{query.p[4], query.p[5], query.p[6], query.p[7]};
  return distance > 0 && judge_proximity(query.kind, end, std::nextafter(distance, 0));
}

/// Whether features touch after the start.
inline bool touches_later(const Query& query) {
  const ExactImpact first = judge_ccd(query);
  if (!first.hit || first.lower > 0) return first.hit;
  Query back = query;  // from the end, where they touch last
  std::ranges::rotate(back.p, back.p.begin() + 4);
  return judge_ccd(back).lower < 1;
}

inline void judge_triangles_of(const StepScene& scene, const std::vector<Vec3d>& y, Findings& findings) {
  const auto corners = [&](const std::array<uint32_t, 3>& t) {
    return std::array<Vec3d, 3>{y[t[0]], y[t[1]], y[t[2]]};
  };
  for (size_t i = 0; i < scene.triangles.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const auto &a = scene.triangles[i], &b = scene.triangles[j];
      if (scene.is_static[scene.mesh[a[0]]] && scene.is_static[scene.mesh[b[0]]]) continue;
      if (std::ranges::any_of(a, [&](uint32_t v) { return std::ranges::find(b, v) != b.end(); })) continue;
      bool is_near = true;
      for (size_t k = 0; k < 3; ++k) {
        const auto [low_a, high_a] = std::minmax({y[a[0]][k], y[a[1]][k], y[a[2]][k]});
        const auto [low_b, high_b] = std::minmax({y[b[0]][k], y[b[1]][k], y[b[2]][k]});
        is_near = is_near && low_a <= high_b && low_b <= high_a;
      }
      findings.crossed += is_near && judge_triangles(corners(a), corners(b));
    }
}

/// Judges at most `most` pairs of each kind of question.
template <class Real>
void judge_step(const StepScene& scene, const SerialSteps<Real>& steps, double m, const std::vector<Vec3d>& x,
                const std::vector<Vec3d>& p, const StepResult& result, size_t most, Random& random,
                Findings& findings) {
  ++findings.steps;
  findings.most_rounds = std::max(findings.most_rounds, result.rounds);
  findings.share += share_of(x, p, result);
  struct Floor {
    Query query;
    double end, way;
  };
  std::vector<Floor> floors;
  std::vector<Query> passages;
  for (const StepPair& pair : result.pairs) {
    const Query query = steps.query_of(pair, x, result.y);
    const bool stands = std::equal(query.p.begin(), query.p.begin() + 4, query.p.begin() + 4);
    if (stands) continue;
    passages.push_back(query);
    if (pair.may_fail && pair.floors.is_tiny) {
      ++findings.tiny;
      findings.passed += touches_later(query);
      continue;
    }
    const double near = 1.5 * (pair.may_fail ? pair.floors.kept : m);
    if (steps.f(pair, result.y) > near && !random.chance(0.1)) continue;
    floors.push_back(pair.may_fail ? Floor{query, pair.floors.end, pair.floors.way} : Floor{query, m, m});
  }
  thin_out(floors, most, random);
  thin_out(passages, most, random);
  for (const Floor& floor : floors) {
    ++findings.ends, ++findings.ways;
    findings.ends_below += is_below(floor.query, floor.end);
    findings.ways_below += judge_ccd(floor.query, floor.way).hit;
  }
  for (const Query& query : passages) ++findings.passages, findings.passed += touches_later(query);
  judge_triangles_of(scene, result.y, findings);
}

}  // namespace collided::test
