// Roots of polynomials that are made of known factors: each once, however often it is one, in order.

#include "gpu/exact/roots/root.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace collided::test {
namespace {

using exact::Form;

/// Its root is at numerator / denominator.
Form root_at(long numerator, long denominator) {
  Form f;
  f.c = {-numerator, denominator - numerator};
  return f;
}
void expect_roots(const Form& f, const std::vector<double>& expected) {
  std::vector<exact::Root> roots = exact::roots_inside(f);
  ASSERT_EQ(roots.size(), expected.size());
  for (size_t i = 0; i < roots.size(); ++i) EXPECT_NEAR(roots[i].rounded_down(), expected[i], 1e-15) << i;
}

TEST(Roots, AreFoundOnceHoweverOftenTheyAreOnes) {
  const Form a = root_at(1, 3), b = root_at(2, 3), half = root_at(1, 2);
  expect_roots(a * b, {1.0 / 3, 2.0 / 3});
  expect_roots(a * b * b, {1.0 / 3, 2.0 / 3});
  expect_roots(a * a * b, {1.0 / 3, 2.0 / 3});
  expect_roots(a * a * b * b, {1.0 / 3, 2.0 / 3});
  expect_roots(a * a * a, {1.0 / 3});
  expect_roots(a * half * half * b, {1.0 / 3, 0.5, 2.0 / 3});
  expect_roots(half * half * half, {0.5});
}

TEST(Roots, AreThoseInside) {
  const Form a = root_at(1, 3);
  expect_roots(a * root_at(0, 1) * root_at(1, 1), {1.0 / 3});
  expect_roots(a * root_at(-1, 5) * root_at(7, 5), {1.0 / 3});
  expect_roots(root_at(-1, 5) * root_at(7, 5), {});
}

// Closer to each other than the halvings that come before the search for double roots tell apart.
TEST(Roots, AreToldApartHoweverCloseTheyAre) {
  constexpr long kMany = 1l << 50;
  const Form near = root_at(kMany / 3, kMany), next = root_at(kMany / 3 + 1, kMany);
  expect_roots(near * next * root_at(2, 3),
               {static_cast<double>(kMany / 3) / kMany, static_cast<double>(kMany / 3 + 1) / kMany, 2.0 / 3});
}

}  // namespace
}  // namespace collided::test
