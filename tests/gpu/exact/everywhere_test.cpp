// Exact decisions are the same bits on every processor. What they begin with is not: a long double has 64 bits on
// x86-64 and 113 on arm64, and fewer decisions are left to integers there.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "gpu/exact/exact.hpp"
#include "tests/gpu/exact/queries.hpp"

namespace collided::test {
namespace {

/// Numbers from the generator's bits alone: the distributions of the standard library may differ.
class Numbers {
 public:
  explicit Numbers(uint64_t seed) : random_(seed) {}
  /// In [-1, 1).
  double any() { return static_cast<double>(static_cast<int64_t>(random_()) >> 11) * 0x1p-52; }
  /// -2, -1, 0, 1 or 2: features often touch in an edge or a corner, or lie in a plane.
  double small() { return static_cast<double>(static_cast<int>(random_() >> 32) % 3); }
  /// Exponents lie far apart.
  double far() {
    const int exponent = static_cast<int>(random_() % 600) - 300;  // compilers differ in which argument comes first
    return std::ldexp(any(), exponent);
  }

 private:
  std::mt19937_64 random_;
};

template <class Number>
Query query_of(Number number) {
  Query q;
  for (auto* points : {&q.start, &q.end})
    for (Point& p : *points) {
      const double x = number(), y = number(), z = number();
      p = {x, y, z};
    }
  return q;
}

class Digest {
 public:
  void add(uint64_t x) {
    for (int i = 0; i < 8; ++i) value_ = (value_ ^ (x >> (8 * i) & 0xff)) * 0x100000001b3;
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325;
};

TEST(ExactEverywhere, TimesHaveTheBitsThatTheyHaveOnOtherProcessors) {
  Numbers numbers(7);
  Digest digest;
  int hits[3] = {};
  for (int i = 0; i < 6000; ++i) {
    Query q = i % 3 == 0   ? query_of([&] { return numbers.any(); })
              : i % 3 == 1 ? query_of([&] { return numbers.small(); })
                           : query_of([&] { return numbers.far(); });
    if (i % 2 == 1) q.thickness = i % 3 == 0 ? 0x1p-4 : 0.25;
    for (const ExactImpact& found : {vertex_triangle(q), edge_edge(q)}) {
      hits[i % 3] += found.hit;
      digest.add(std::bit_cast<uint64_t>(found.toi));
      digest.add(uint64_t{found.hit} + 2 * uint64_t{found.initial});
    }
  }
  for (const int of_family : hits) EXPECT_GT(of_family, 100);
  EXPECT_EQ(digest.value(), 2299072939560909715u);
}

}  // namespace
}  // namespace collided::test
