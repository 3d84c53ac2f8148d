#pragma once
// Systems of five linear equations in rationals, for judges of common points.

#include <gmpxx.h>

#include <array>
#include <optional>
#include <utility>
#include <vector>

namespace collided::test {

/// A row is an equation. Its last number is the right side.
using FiveEquations = std::array<std::array<mpq_class, 6>, 5>;

/// Returns the only solution for the first `unknowns` columns; none if there is no solution, or more than one.
inline std::optional<std::vector<mpq_class>> only_solution(FiveEquations m, size_t unknowns) {
  for (size_t k = 0; k < unknowns; ++k) {
    size_t pivot = k;
    while (pivot < 5 && m[pivot][k] == 0) ++pivot;
    if (pivot == 5) return std::nullopt;
    std::swap(m[k], m[pivot]);
    for (size_t row = 0; row < 5; ++row) {
      if (row == k || m[row][k] == 0) continue;
      const mpq_class factor = m[row][k] / m[k][k];
      for (size_t j = k; j < 6; ++j)
        if (m[k][j] != 0) m[row][j] -= factor * m[k][j];
    }
  }
  for (size_t row = unknowns; row < 5; ++row)
    if (m[row][5] != 0) return std::nullopt;
  std::vector<mpq_class> solution;
  for (size_t k = 0; k < unknowns; ++k) solution.push_back(m[k][5] / m[k][k]);
  return solution;
}

}  // namespace collided::test
