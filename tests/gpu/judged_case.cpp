#include "tests/gpu/judged_case.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/adversarial.hpp"

namespace collided::test {
namespace {

using Corners = std::array<uint32_t, 3>;

ptrdiff_t common_corners(const Corners& a, const Corners& b) {
  return std::ranges::count_if(a, [&](uint32_t v) { return std::ranges::find(b, v) != b.end(); });
}

/// `a`, turned so that a corner of `b` is its first.
Corners turned_to(Corners a, const Corners& b) {
  std::ranges::rotate(a, std::ranges::find_first_of(a, b));
  return a;
}

}  // namespace

CaseJudge::CaseJudge(const Case& c, Mode mode, double thickness) : queries_(c), mode_(mode), thickness_(thickness) {
  for (const MeshSpec& mesh : c.meshes) halves_.push_back(mesh.half_thickness);
}

ExactImpact CaseJudge::judge(const Query& query, const Thickness& thickness) const {
  if (mode_ == Mode::kCcd) return judge_ccd(query, thickness);
  const std::array<Vec3d, 4> at_end{query.p[4], query.p[5], query.p[6], query.p[7]};
  return {judge_proximity(query.kind, at_end, thickness), 0, 0};
}

Truth CaseJudge::judge(QueryKind kind, const Pairs& pairs) const {
  Truth truth;
  for (const auto& [first, second] : pairs) {
    const PairKey key = key_of(first, second);
    const auto vertices = queries_.vertices_of(kind, key);
    const auto half = [&](uint32_t vertex) { return halves_[queries_.features().mesh_of_vertex[vertex]]; };
    ExactImpact impact =
        judge(queries_.of_vertices(kind, vertices), {thickness_, half(vertices[0]), half(vertices[3])});
    if (impact.hit) truth.emplace(key, std::move(impact));
  }
  return truth;
}

std::vector<PairKey> CaseJudge::triangles() const {
  std::vector<PairKey> keys;
  const auto& triangles = queries_.features().triangles;
  const Positions& end = queries_.end();
  const auto at = [&](const Corners& c) { return std::array<Vec3d, 3>{end[c[0]], end[c[1]], end[c[2]]}; };
  const auto meet = [&](const Corners& a, const Corners& b) {
    const ptrdiff_t common = common_corners(a, b);
    if (common == 0) return judge_triangles(at(a), at(b));
    return common == 1 && judge_neighbours(at(turned_to(a, b)), at(turned_to(b, a)));
  };
  const auto is_triangle = [&](uint32_t t) { return queries_.features().kinds[t] == ElementKind::kTriangle; };
  const auto count = static_cast<uint32_t>(triangles.size());
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = i + 1; j < count; ++j)
      if (is_triangle(i) && is_triangle(j) && meet(triangles[i], triangles[j])) keys.push_back(key_of(i, j));
  return keys;
}

std::vector<PairKey> keys_of(const ContactSet& contacts) {
  std::vector<PairKey> keys;
  for (const auto& e : contacts.elements) keys.push_back(key_of(e[0], e[1]));
  return keys;
}

std::vector<PairKey> keys_of(const Truth& truth) {
  std::vector<PairKey> keys;
  for (const auto& [key, impact] : truth) keys.push_back(key);
  return keys;
}

Case lattice(uint32_t seed, uint32_t count, double side) {
  constexpr double kSize = 4;
  return on_integers(soup(seed, count, side, kSize, kSize));
}

Case crumpled(uint32_t seed, uint32_t n, double by) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> move(-by, by);
  Positions positions;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i <= n; ++i)
    for (uint32_t j = 0; j <= n; ++j) positions.push_back({i + move(random), j + move(random), move(random)});
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j) {
      const uint32_t a = i * (n + 1) + j, b = a + 1, c = a + n + 1, d = c + 1;
      triangles.push_back({a, c, b}), triangles.push_back({b, c, d});
    }
  Case c;
  add_mesh(c, triangles, positions);
  return c;
}

std::string level_name(Accuracy accuracy) {
  constexpr const char* kNames[] = {"CANDIDATES", "FAST", "GUARDED", "CERTIFIED", "EXACT"};
  return kNames[static_cast<size_t>(accuracy)];
}

}  // namespace collided::test
