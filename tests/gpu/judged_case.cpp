#include "tests/gpu/judged_case.hpp"

#include <algorithm>
#include <cmath>

#include "tests/support/adversarial.hpp"

namespace collided::test {
namespace {

bool share_a_vertex(const std::array<uint32_t, 3>& a, const std::array<uint32_t, 3>& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
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
  const auto corners = [&](uint32_t t) {
    const auto& c = triangles[t];
    return std::array<Vec3d, 3>{end[c[0]], end[c[1]], end[c[2]]};
  };
  const auto is_triangle = [&](uint32_t t) { return queries_.features().kinds[t] == ElementKind::kTriangle; };
  const auto count = static_cast<uint32_t>(triangles.size());
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = i + 1; j < count; ++j)
      if (is_triangle(i) && is_triangle(j) && !share_a_vertex(triangles[i], triangles[j]) &&
          judge_triangles(corners(i), corners(j)))
        keys.push_back(key_of(i, j));
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

std::string level_name(Accuracy accuracy) {
  constexpr const char* kNames[] = {"CANDIDATES", "FAST", "GUARDED", "CERTIFIED", "EXACT"};
  return kNames[static_cast<size_t>(accuracy)];
}

}  // namespace collided::test
