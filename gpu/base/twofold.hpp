#pragma once
// Numbers of twice double's precision: sums of two doubles that do not overlap (Dekker, 1971). With u = 2^-53, a
// difference of two doubles is exact; a sum is within 3u^2 of its terms' magnitudes, a product within 8u^2 of its own.
// Numbers have to be of ordinary size, so that no product underflows or overflows.

#include "gpu/base/vec3.hpp"

namespace collided {

struct Twofold {
  double high = 0, low = 0;
};

/// a + b without error.
COLLIDED_HD inline Twofold exact_sum(double a, double b) {
  const double sum = a + b, of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}
/// The same where a is not smaller than b, or is 0.
COLLIDED_HD inline Twofold exact_sum_of_ordered(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}
/// a * b without error.
COLLIDED_HD inline Twofold exact_product(double a, double b) {
  const double product = a * b;
#ifdef __CUDA_ARCH__
  return {product, fma(a, b, -product)};
#else
  // By halves of 26 bits: without a unit for it, fma is a slow call. The same two numbers.
  const auto upper = [](double x) {
    const double y = x * 0x1.0000002p27;
    return y - (y - x);
  };
  const double a1 = upper(a), a2 = a - a1, b1 = upper(b), b2 = b - b1;
  return {product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2};
#endif
}

COLLIDED_HD inline Twofold operator-(const Twofold& a) { return {-a.high, -a.low}; }
COLLIDED_HD inline Twofold operator+(const Twofold& a, const Twofold& b) {
  const Twofold sum = exact_sum(a.high, b.high);
  return exact_sum_of_ordered(sum.high, sum.low + (a.low + b.low));
}
COLLIDED_HD inline Twofold operator-(const Twofold& a, const Twofold& b) { return a + -b; }
COLLIDED_HD inline Twofold operator*(const Twofold& a, const Twofold& b) {
  const Twofold product = exact_product(a.high, b.high);
  return exact_sum_of_ordered(product.high, product.low + (a.high * b.low + a.low * b.high));
}
/// Without error, `scale` being a power of two.
COLLIDED_HD inline Twofold scaled(const Twofold& a, double scale) { return {a.high * scale, a.low * scale}; }

COLLIDED_HD inline Vec3<Twofold> exact_difference(const Vec3<double>& a, const Vec3<double>& b) {
  return {exact_sum(a.x, -b.x), exact_sum(a.y, -b.y), exact_sum(a.z, -b.z)};
}
COLLIDED_HD inline Vec3<Twofold> scaled(const Vec3<Twofold>& a, double scale) {
  return {scaled(a.x, scale), scaled(a.y, scale), scaled(a.z, scale)};
}
COLLIDED_HD inline Vec3<double> rounded(const Vec3<Twofold>& a) { return {a.x.high, a.y.high, a.z.high}; }

}  // namespace collided
