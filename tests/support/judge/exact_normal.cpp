// How a direction lies between two features, in rational arithmetic.
#include "tests/support/judge/exact_normal.hpp"

#include <algorithm>

namespace collided::test {

ExactNormal judge_normal(const Query& query, const mpq_class& t, const std::array<float, 3>& n) {
  const std::array<mpq_class, 3> direction = {mpq_class(n[0]), mpq_class(n[1]), mpq_class(n[2])};
  ExactNormal out;
  for (const mpq_class& component : direction) out.squared_length += component * component;
  std::array<mpq_class, 4> along;
  for (size_t i = 0; i < 4; ++i)
    for (size_t axis = 0; axis < 3; ++axis) {
      const mpq_class start(query.p[i][axis]), end(query.p[i + 4][axis]);
      along[i] += direction[axis] * (start + t * (end - start));
    }
  const auto second = along.begin() + (query.kind == QueryKind::kVertexTriangle ? 1 : 2);
  out.gap = *std::min_element(along.begin(), second) - *std::max_element(second, along.end());
  return out;
}

}  // namespace collided::test
