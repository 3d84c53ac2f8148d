#include "gpu/exact/closest_features.hpp"

#include "gpu/base/closest_features.hpp"
#include "gpu/exact/integers.hpp"

namespace collided {
namespace {

/// Differences of integers that are below 2^(w - 4), as in exact/fixed/differences.hpp: dot products are below
/// 2^(2 w - 4) and the polynomials of degree 4 below 2^(4 w - 7).
template <class Int>
struct IntegerNumbers {
  const Vec3<Int>* p;

  Vec3<Int> d(int i, int j) const { return p[j] - p[i]; }
  auto dot(const Vec3<Int>& a, const Vec3<Int>& b) const { return exact::fixed::wide_dot(a, b); }
  template <class Number>
  Judged not_positive(const Number& x) const {
    return {x.sign() <= 0, true};
  }
};

}  // namespace

uint8_t exact_closest_features(ContactKind kind, const Vec3<double> (&points)[4], const uint32_t (&ids)[4]) {
  FoundFeatures found{};
  exact::with_integers(points, [&]<class Int>(const Vec3<Int>* p) {
    const IntegerNumbers<Int> numbers{p};
    const ClosestFeatureRules rules(numbers, ids);
    found = kind == ContactKind::kVertexTriangle ? rules.vertex_triangle() : rules.edge_edge();
  });
  return found.features;
}

}  // namespace collided
