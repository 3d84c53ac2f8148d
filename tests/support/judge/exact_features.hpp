#pragma once
// On which features of a pair the closest points are, in rational arithmetic and without conditions of optimality:
// every pair of hulls is minimised by itself, and distances are compared.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {

using ExactPoint = std::array<mpq_class, 3>;
ExactPoint exact_point(const Vec3d& p);
ExactPoint operator-(const ExactPoint& a, const ExactPoint& b);
mpq_class product(const ExactPoint& a, const ExactPoint& b);

/// The shortest vector from the second to the first of two hulls: of a point, a line or a plane.
struct HullGap {
  ExactPoint vector;
  bool is_inside;  ///< both ends are between the points that the hulls are of
};
/// Hulls of one point to three each, at most four together. Nothing if there are several such vectors' ends.
std::optional<HullGap> gap_of_hulls(std::span<const ExactPoint> first, std::span<const ExactPoint> second);

/// A feature of the first and one of the second of a pair: their vertices by their place in v a b c or a0 a1 b0 b1, and
/// the byte of ClosestFeatures (gpu/contact_set.hpp) for them.
struct FeaturePair {
  std::vector<size_t> first, second;
  uint8_t features;
  std::vector<size_t> named;  ///< vertices whose ids break ties
};
/// By ascending byte.
const std::vector<FeaturePair>& feature_pairs(QueryKind kind);
/// Of those, the one with this byte; null if there is none.
const FeaturePair* find_feature_pair(QueryKind kind, uint8_t features);

struct JudgedFeatures {
  uint8_t features;
  mpq_class squared;  ///< distance
  int ties;           ///< pairs of features at this distance
  bool is_equal;      ///< of them, several of the lowest dimension
};
JudgedFeatures judge_features(QueryKind kind, const std::array<ExactPoint, 4>& p, const std::array<uint32_t, 4>& ids);

}  // namespace collided::test
