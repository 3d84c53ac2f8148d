#include "tests/support/judge/exact_features.hpp"

#include <algorithm>

namespace collided::test {

ExactPoint exact_point(const Vec3d& p) { return {mpq_class(p[0]), mpq_class(p[1]), mpq_class(p[2])}; }
ExactPoint operator-(const ExactPoint& a, const ExactPoint& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
mpq_class product(const ExactPoint& a, const ExactPoint& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

std::optional<HullGap> gap_of_hulls(std::span<const ExactPoint> first, std::span<const ExactPoint> second) {
  const ExactPoint r = first[0] - second[0];
  std::vector<ExactPoint> way;  // r + sum of weights times ways is to be as short as possible
  for (size_t i = 1; i < first.size(); ++i) way.push_back(first[i] - first[0]);
  for (size_t i = 1; i < second.size(); ++i) way.push_back(second[0] - second[i]);
  std::vector<mpq_class> weight(way.size());
  if (way.size() == 1) {
    const mpq_class length = product(way[0], way[0]);
    if (length == 0) return std::nullopt;
    weight[0] = -product(r, way[0]) / length;
  } else if (way.size() == 2) {
    const mpq_class a = product(way[0], way[0]), b = product(way[0], way[1]), c = product(way[1], way[1]),
                    determinant = a * c - b * b, u = -product(r, way[0]), v = -product(r, way[1]);
    if (determinant == 0) return std::nullopt;
    weight[0] = (u * c - v * b) / determinant;
    weight[1] = (a * v - b * u) / determinant;
  }
  HullGap gap{r, true};
  mpq_class of_first = 0, of_second = 0;
  for (size_t i = 0; i < weight.size(); ++i) {
    gap.is_inside = gap.is_inside && weight[i] >= 0;
    (i + 1 < first.size() ? of_first : of_second) += weight[i];
    for (size_t k = 0; k < 3; ++k) gap.vector[k] += weight[i] * way[i][k];
  }
  gap.is_inside = gap.is_inside && of_first <= 1 && of_second <= 1;
  return gap;
}

const std::vector<FeaturePair>& feature_pairs(QueryKind kind) {
  static const std::vector<FeaturePair> of_vertex_triangle = {
      {{0}, {1, 2, 3}, 0, {}}, {{0}, {2, 3}, 1, {2, 3}}, {{0}, {1, 3}, 2, {1, 3}}, {{0}, {1, 2}, 3, {1, 2}},
      {{0}, {1}, 4, {1}},      {{0}, {2}, 5, {2}},       {{0}, {3}, 6, {3}},
  };
  static const std::vector<FeaturePair> of_edges = {
      {{0, 1}, {2, 3}, 0, {}}, {{0}, {2, 3}, 1, {0}}, {{1}, {2, 3}, 2, {1}},
      {{0, 1}, {2}, 4, {2}},   {{0}, {2}, 5, {0, 2}}, {{1}, {2}, 6, {1, 2}},
      {{0, 1}, {3}, 8, {3}},   {{0}, {3}, 9, {0, 3}}, {{1}, {3}, 10, {1, 3}},
  };
  return kind == QueryKind::kVertexTriangle ? of_vertex_triangle : of_edges;
}

const FeaturePair* find_feature_pair(QueryKind kind, uint8_t features) {
  for (const FeaturePair& pair : feature_pairs(kind))
    if (pair.features == features) return &pair;
  return nullptr;
}

JudgedFeatures judge_features(QueryKind kind, const std::array<ExactPoint, 4>& p, const std::array<uint32_t, 4>& ids) {
  struct Found {
    mpq_class squared;
    std::vector<size_t> order;  ///< dimension, then ids
    uint8_t features;
  };
  std::vector<Found> all;
  for (const FeaturePair& pair : feature_pairs(kind)) {
    std::vector<ExactPoint> first, second;
    for (const size_t i : pair.first) first.push_back(p[i]);
    for (const size_t i : pair.second) second.push_back(p[i]);
    const std::optional<HullGap> gap = gap_of_hulls(first, second);
    if (!gap || !gap->is_inside) continue;
    Found found{product(gap->vector, gap->vector), {}, pair.features};
    for (const size_t i : pair.named) found.order.push_back(ids[i]);
    std::sort(found.order.begin(), found.order.end());
    found.order.insert(found.order.begin(), first.size() + second.size());
    all.push_back(std::move(found));
  }
  std::stable_sort(all.begin(), all.end(), [](const Found& a, const Found& b) {
    const int by_distance = cmp(a.squared, b.squared);
    return by_distance != 0 ? by_distance < 0 : a.order < b.order;
  });
  JudgedFeatures judged{all[0].features, all[0].squared, 0, false};
  for (const Found& found : all) {
    if (found.squared != judged.squared) break;
    judged.is_equal = judged.is_equal || (judged.ties > 0 && found.order[0] == all[0].order[0]);
    ++judged.ties;
  }
  return judged;
}

}  // namespace collided::test
