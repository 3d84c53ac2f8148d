#pragma once
// Medians and quantiles of a few measured values.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace collided::cli {

/// The mean of the middle two if the number of values is even. There must be a value.
inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

/// The smallest value that is at least as large as the fraction `rank`, in [0, 1], of all values. Reorders the values,
/// of which there must be one.
inline double quantile(std::vector<double>& values, double rank) {
  const auto n = static_cast<double>(values.size());
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max(1.0, std::ceil(rank * n))) - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace collided::cli
