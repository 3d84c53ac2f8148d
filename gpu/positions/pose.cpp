#include "gpu/positions/pose.hpp"

#include <cmath>

namespace collided {

double rotation_defect(const Pose& pose) {
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      double product = i == k ? -1 : 0;
      for (int row = 0; row < 3; ++row) product += pose.r(row, i) * pose.r(row, k);
      sum += product * product;
    }
  return std::sqrt(sum);
}

double determinant(const Pose& pose) {
  const Vec3<double> a{pose.r(0, 0), pose.r(0, 1), pose.r(0, 2)}, b{pose.r(1, 0), pose.r(1, 1), pose.r(1, 2)},
      c{pose.r(2, 0), pose.r(2, 1), pose.r(2, 2)};
  return triple(a, b, c);
}

}  // namespace collided
