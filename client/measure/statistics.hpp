#pragma once
// Medians and quantiles of a few measured values.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace collided::cli {

/// Of an even number of values, the mean of the middle two. There must be a value.
inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

/// The smallest value that at least the part `rank`, in [0, 1], of all values does not exceed; reorders the values.
/// There must be a value.
inline double quantile(std::vector<double>& values, double rank) {
  const auto n = static_cast<double>(values.size());
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max(1.0, std::ceil(rank * n))) - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace collided::cli
