#include "tests/gpu/judged_case.hpp"

#include <algorithm>
#include <cmath>

#include "tests/support/adversarial.hpp"

namespace collided::test {
namespace {

Positions joined(const std::vector<Positions>& parts) {
  Positions all;
  for (const Positions& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

bool share_a_vertex(const std::array<uint32_t, 3>& a, const std::array<uint32_t, 3>& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

}  // namespace

CaseJudge::CaseJudge(const Case& c, Mode mode, double thickness)
    : features_(features_of(c)), mode_(mode), thickness_(thickness), start_(joined(c.start)), end_(joined(c.end)) {}

ExactImpact CaseJudge::judge(QueryKind kind, const std::array<uint32_t, 4>& vertices) const {
  std::array<Vec3d, 4> at_end;
  Query query{kind, {}};
  for (size_t k = 0; k < 4; ++k) {
    query.p[k] = start_[vertices[k]];
    query.p[k + 4] = at_end[k] = end_[vertices[k]];
  }
  if (mode_ == Mode::kDcd) return {judge_proximity(kind, at_end, thickness_), 0, 0};
  return judge_ccd(query, thickness_);
}

Truth CaseJudge::vertex_triangle(std::span<const std::array<uint32_t, 2>> pairs) const {
  Truth truth;
  for (const auto& [v, t] : pairs) {
    const auto& c = features_.triangles[t];
    ExactImpact impact = judge(QueryKind::kVertexTriangle, {v, c[0], c[1], c[2]});
    if (impact.hit) truth.emplace(key_of(v, t), std::move(impact));
  }
  return truth;
}

Truth CaseJudge::edge_edge(std::span<const std::array<uint32_t, 2>> pairs) const {
  Truth truth;
  for (const auto& [i, j] : pairs) {
    const auto &e = features_.edges[i], &f = features_.edges[j];
    ExactImpact impact = judge(QueryKind::kEdgeEdge, {e[0], e[1], f[0], f[1]});
    if (impact.hit) truth.emplace(key_of(i, j), std::move(impact));
  }
  return truth;
}

std::vector<PairKey> CaseJudge::triangles() const {
  std::vector<PairKey> keys;
  const auto corners = [&](uint32_t t) {
    const auto& c = features_.triangles[t];
    return std::array<Vec3d, 3>{end_[c[0]], end_[c[1]], end_[c[2]]};
  };
  const auto count = static_cast<uint32_t>(features_.triangles.size());
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = i + 1; j < count; ++j)
      if (!share_a_vertex(features_.triangles[i], features_.triangles[j]) && judge_triangles(corners(i), corners(j)))
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
  Case c = soup(seed, count, side, kSize, kSize);
  for (Positions* positions : {&c.start[0], &c.end[0]})
    for (Vec3d& p : *positions)
      for (double& x : p) x = std::round(x);
  return c;
}

std::string level_name(Accuracy accuracy) {
  constexpr const char* kNames[] = {"CANDIDATES", "FAST", "GUARDED", "CERTIFIED", "EXACT"};
  return kNames[static_cast<size_t>(accuracy)];
}

}  // namespace collided::test
