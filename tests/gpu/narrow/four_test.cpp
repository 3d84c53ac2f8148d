// Four numbers side by side become what each of them would alone, to the last bit.

#include "gpu/base/four.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace collided::test {
namespace {

template <class T>
class FourNumbers : public testing::Test {
 protected:
  using Limits = std::numeric_limits<T>;

  /// In fours: each number with three others, in each place once.
  template <class Check>
  static void for_each_four(const Check& check) {
    const std::vector<T> numbers = {0,
                                    -T(0),
                                    1,
                                    -1,
                                    T(1) / 3,
                                    T(2.5),
                                    T(-7) / 3,
                                    Limits::min(),
                                    Limits::max(),
                                    -Limits::max(),
                                    Limits::denorm_min(),
                                    Limits::infinity(),
                                    -Limits::infinity(),
                                    Limits::quiet_NaN(),
                                    T(1e-30),
                                    T(1e30)};
    for (size_t i = 0; i < numbers.size(); ++i)
      for (size_t j = 0; j < numbers.size(); ++j) {
        Four<T> a, b;
        for (size_t k = 0; k < 4; ++k) {
          a.set(static_cast<int>(k), numbers[(i + k) % numbers.size()]);
          b.set(static_cast<int>(k), numbers[(j + 3 * k) % numbers.size()]);
        }
        check(a, b);
      }
  }
  static void expect_same(const Four<T>& found, int k, T expected, T a, T b) {
    if (expected != expected)
      EXPECT_NE(found[k], found[k]) << a << ' ' << b;
    else
      EXPECT_EQ(detail::bit_copy<Bits>(found[k]), detail::bit_copy<Bits>(expected)) << a << ' ' << b;
  }

 private:
  using Bits = typename detail::Bits<T>::Type;
};
using FourTypes = testing::Types<float, double>;
TYPED_TEST_SUITE(FourNumbers, FourTypes);

TYPED_TEST(FourNumbers, AreComputedWithAsEach) {
  using T = TypeParam;
  this->for_each_four([&](const Four<T>& a, const Four<T>& b) {
    for (int k = 0; k < 4; ++k) {
      const auto same = [&](const Four<T>& found, T expected) { this->expect_same(found, k, expected, a[k], b[k]); };
      same(a + b, a[k] + b[k]);
      same(a - b, a[k] - b[k]);
      same(a * b, a[k] * b[k]);
      same(a / b, a[k] / b[k]);
      same(min(a, b), min(a[k], b[k]));
      same(max(a, b), max(a[k], b[k]));
      same(magnitude(a), magnitude(a[k]));
      same(Four<T>(Four<double>(a)), static_cast<T>(static_cast<double>(a[k])));
    }
  });
}

TYPED_TEST(FourNumbers, AreComparedAsEach) {
  using T = TypeParam;
  this->for_each_four([&](const Four<T>& a, const Four<T>& b) {
    for (int k = 0; k < 4; ++k) {
      const auto has = [&](const FourMask<T>& mask) { return (mask.bits() >> k & 1u) != 0; };
      EXPECT_EQ(has(a < b), a[k] < b[k]);
      EXPECT_EQ(has(a > b), a[k] > b[k]);
      EXPECT_EQ(has(a <= b), a[k] <= b[k]);
      EXPECT_EQ(has(a >= b), a[k] >= b[k]);
      EXPECT_EQ(has(a == b), a[k] == b[k]);
      EXPECT_EQ(has(a != b), a[k] != b[k]);
      EXPECT_EQ(has(!(a < b)), !(a[k] < b[k]));
      EXPECT_EQ(has((a < b) | (a == b)), a[k] <= b[k]);
      EXPECT_EQ(has((a <= b) & (a >= b)), a[k] == b[k]);
      this->expect_same(select(a < b, a, b), k, a[k] < b[k] ? a[k] : b[k], a[k], b[k]);
    }
    EXPECT_EQ(any(a < b), a[0] < b[0] || a[1] < b[1] || a[2] < b[2] || a[3] < b[3]);
    EXPECT_EQ(all(a < b), a[0] < b[0] && a[1] < b[1] && a[2] < b[2] && a[3] < b[3]);
  });
}

TYPED_TEST(FourNumbers, HaveTheScalesOfEach) {
  using T = TypeParam;
  const Four<T> scale = unit_scale(Four<T>(typename Four<T>::Vector{T(1e-40), T(0.3), T(1), T(1e30)}));
  const T numbers[] = {T(1e-40), T(0.3), T(1), T(1e30)};
  for (int k = 0; k < 4; ++k) EXPECT_EQ(scale[k], unit_scale(numbers[k]));
}

TEST(FourFloats, HaveTheRootsOfEach) {
  const float numbers[] = {2, 0, 1e-40f, 1e38f, -0.0f, 0.7f, 3, 1e-20f};
  for (int first = 0; first < 8; first += 4) {
    Four<float> a;
    for (int k = 0; k < 4; ++k) a.set(k, numbers[first + k]);
    for (int k = 0; k < 4; ++k)
      EXPECT_EQ(detail::bit_copy<uint32_t>(square_root(a)[k]),
                detail::bit_copy<uint32_t>(std::sqrt(numbers[first + k])));
  }
  EXPECT_NE(square_root(Four<float>(-1.0f))[2], square_root(Four<float>(-1.0f))[2]);
}

TEST(FourFloats, AreRoundedUpAsEach) {
  const double numbers[] = {0.1, 1, 1e-60, 3e38};
  Four<double> x;
  for (int k = 0; k < 4; ++k) x.set(k, numbers[k]);
  const Four<float> above = float_above(x), scaled = scaled_thickness<float>(0.1, x),
                    none = scaled_thickness<float>(0, x);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(above[k], float_above(numbers[k]));
    EXPECT_EQ(scaled[k], (scaled_thickness<float>(0.1, numbers[k])));
    EXPECT_EQ(none[k], 0);
  }
}

}  // namespace
}  // namespace collided::test
