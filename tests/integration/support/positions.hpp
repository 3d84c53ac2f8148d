#pragma once
// Little-endian arrays as in the protocol.

#include <array>
#include <string>
#include <vector>

namespace collided::test {

using Points = std::vector<std::array<double, 3>>;

template <class T>
std::string pack(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

inline std::string pack_points(const Points& points, bool wide = false) {
  std::vector<double> doubles;
  for (const auto& point : points) doubles.insert(doubles.end(), point.begin(), point.end());
  return wide ? pack(doubles) : pack(std::vector<float>(doubles.begin(), doubles.end()));
}

}  // namespace collided::test
