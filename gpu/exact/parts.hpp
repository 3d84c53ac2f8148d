#pragma once
// The polynomials that the conditions of exact/features.cpp are built from, in exact or in rough numbers. These are the
// differences of the features' corners, in the order of fixed/differences.hpp, the cross products of all sides, the
// features' normal n, and the volume. Each is computed on first use.
//
// With A, B, C from the corners to the vertex, n = (b - a) x (c - a) = B x C + C x A + A x B, and the volume is
// A (B x C). With A = a0 - b0, B = a0 - b1, C = a1 - b0, D = a1 - b1, n = (a1 - a0) x (b1 - b0) = A x B + D x C, and
// the volume is C (A x B).

#include <array>
#include <optional>
#include <utility>

#include "gpu/exact/fixed/differences.hpp"
#include "gpu/exact/integers.hpp"
#include "gpu/exact/rough/motion.hpp"

namespace collided::exact {

template <class T>
class Memo {
 public:
  template <class Make>
  const T& get(const Make& make) const {
    if (!value_) value_ = make();
    return *value_;
  }

 private:
  mutable std::optional<T> value_;
};

template <class Linear>
using QuadraticOf = decltype(std::declval<Linear>() * std::declval<Linear>());
template <class Linear>
using CubicOf = decltype(std::declval<QuadraticOf<Linear>>() * std::declval<Linear>());

/// Exact numbers: forms, or polynomials of fixed size.
template <ContactKind kind, class Linear>
class ExactParts {
 public:
  explicit ExactParts(const QueryOf<Linear>& query) : limit_(query.limit) {
    const auto& p = query.points;
    for (size_t i = 0; i < kCount; ++i) d_[i] = kCount == 3 ? p[0] - p[i + 1] : p[i / 2] - p[2 + i % 2];
  }

  const Linear& limit() const { return limit_; }
  const Vec3<Linear>& d(int i) const { return d_[static_cast<size_t>(i)]; }
  /// P - Q of a side.
  Vec3<Linear> edge(int i) const {
    const fixed::Side side = fixed::Sides<kind>::at(i);
    return d(side.p) - d(side.q);
  }
  const Vec3<QuadraticOf<Linear>>& side(int i) const {
    return sides_[static_cast<size_t>(i)].get([&] {
      const fixed::Side side = fixed::Sides<kind>::at(i);
      return fixed::wide_cross(d(side.p), d(side.q));
    });
  }
  const Vec3<QuadraticOf<Linear>>& n() const {
    return n_.get([&] { return kCount == 3 ? side(0) + side(1) + side(2) : side(0) + side(1); });
  }
  const CubicOf<Linear>& volume() const {
    return volume_.get([&] { return fixed::wide_dot(d(kCount == 3 ? 0 : 2), side(0)); });
  }

 private:
  static constexpr size_t kCount = fixed::Differences<kind, 1>::kCount;

  Linear limit_;
  std::array<Vec3<Linear>, kCount> d_;
  std::array<Memo<Vec3<QuadraticOf<Linear>>>, fixed::Sides<kind>::kCount> sides_;
  Memo<Vec3<QuadraticOf<Linear>>> n_;
  Memo<CubicOf<Linear>> volume_;
};

/// Rough numbers. A difference drops what is far below it, and the sums above may be made of nothing else. So the cross
/// products and the volume are made of coordinates here: of terms that differ from each other, none of which is the sum
/// of the others. Degree 0: the end of the way alone.
template <ContactKind kind, int degree>
class RoughParts {
 public:
  using Linear = RoughPolynomial<degree>;
  using Quadratic = RoughPolynomial<2 * degree>;

  explicit RoughParts(const RoughMotion& motion) : motion_(motion) {
    for (int e = 0; e <= degree; ++e) limit_.c[e] = end(e).limit;
    for (size_t i = 0; i < kCount; ++i) d_[i] = kCount == 3 ? difference(0, i + 1) : difference(i / 2, 2 + i % 2);
  }

  const Linear& limit() const { return limit_; }
  const Vec3<Linear>& d(int i) const { return d_[static_cast<size_t>(i)]; }
  Vec3<Linear> edge(int i) const {
    const auto& [p, q, r] = kCorners[i];
    return p < (kCount == 3 ? 1 : 2) ? difference(r, q) : difference(q, r);
  }
  const Vec3<Quadratic>& side(int i) const {
    return sides_[static_cast<size_t>(i)].get([&] {
      const auto& [p, q, r] = kCorners[i];
      return normal(p, q, r);
    });
  }
  const Vec3<Quadratic>& n() const {
    return n_.get(
        [&] { return kCount == 3 ? normal(1, 2, 3) : fixed::wide_cross(difference(1, 0), difference(3, 2)); });
  }
  /// Along x, by cofactors, whose sum is 0.
  const RoughPolynomial<3 * degree>& volume() const {
    return volume_.get([&] {
      RoughPolynomial<3 * degree> volume{};
      for (int e = 0; e <= degree; ++e) {
        const Quadratic part = volume_at(end(e).axes[0]);
        for (int k = 0; k <= 2 * degree; ++k) volume.c[e + k] = volume.c[e + k] + part.c[k];
      }
      return volume;
    });
  }

 private:
  static constexpr size_t kCount = fixed::Differences<kind, 1>::kCount;
  /// Of each side, the point that P and Q have in common, and their others. P and Q lead to it where it is one of the
  /// first feature's, else from it.
  static constexpr size_t kCorners[4][3] = {{0, 2, 3},
                                            {kCount == 3 ? 0 : 1, 3, kCount == 3 ? 1 : 2},
                                            {kCount == 3 ? 0 : 2, 1, kCount == 3 ? 2 : 0},
                                            {3, 0, 1}};

  const RoughMotion::End& end(int i) const { return motion_.end(degree == 0 ? 1 : i); }
  Linear difference(size_t axis, size_t i, size_t j) const {
    Linear line;
    for (int e = 0; e <= degree; ++e) line.c[e] = end(e).axes[axis].difference[i][j];
    return line;
  }
  Vec3<Linear> difference(size_t i, size_t j) const {
    return {difference(0, i, j), difference(1, i, j), difference(2, i, j)};
  }
  /// (q - p) x (r - p), of the coordinates along one axis and differences along the other.
  Vec3<Quadratic> normal(size_t p, size_t q, size_t r) const {
    return {minor(1, 2, p, q, r), minor(2, 0, p, q, r), minor(0, 1, p, q, r)};
  }
  Quadratic minor(size_t axis, size_t other, size_t p, size_t q, size_t r) const {
    const Linear qr = difference(other, q, r), rp = difference(other, r, p), pq = difference(other, p, q);
    Quadratic minor{};
    for (int e = 0; e <= degree; ++e) {
      const RoughMotion::Axis& x = end(e).axes[axis];
      const Linear part = x.are_equal(p, q)   ? x.difference[r][p] * pq
                          : x.are_equal(q, r) ? x.difference[p][q] * qr
                          : x.are_equal(r, p) ? x.difference[q][r] * rp
                                              : x.at[p] * qr + x.at[q] * rp + x.at[r] * pq;
      for (int k = 0; k <= degree; ++k) minor.c[e + k] = minor.c[e + k] + part.c[k];
    }
    return minor;
  }
  /// Of a point's coordinate along x.
  Quadratic cofactor(size_t i) const {
    if (kCount == 3) return i == 0 ? n().x : -side(static_cast<int>(i) - 1).x;
    return i == 0 ? side(1).x : i == 1 ? side(0).x : i == 2 ? -side(3).x : -side(2).x;
  }
  Quadratic volume_at(const RoughMotion::Axis& x) const {
    constexpr size_t kPairs[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                     {2, 3, 0, 1}, {3, 1, 0, 2}, {1, 2, 0, 3}};  // even permutations
    for (const auto& [i, j, k, l] : kPairs) {
      if (!x.are_equal(i, j)) continue;
      // The sum of the cofactors of i and j.
      const Quadratic both = difference(1, i, j) * difference(2, l, k) - difference(2, i, j) * difference(1, l, k),
                      sum = kCount == 3 ? both : -both;
      if (x.are_equal(k, l)) return x.difference[i][k] * sum;
      if (x.are_equal(i, k)) return x.difference[l][i] * cofactor(l);
      if (x.are_equal(i, l)) return x.difference[k][i] * cofactor(k);
      return x.at[i] * sum + x.at[k] * cofactor(k) + x.at[l] * cofactor(l);
    }
    return x.at[0] * cofactor(0) + x.at[1] * cofactor(1) + x.at[2] * cofactor(2) + x.at[3] * cofactor(3);
  }

  const RoughMotion& motion_;
  Linear limit_;
  std::array<Vec3<Linear>, kCount> d_;
  std::array<Memo<Vec3<Quadratic>>, fixed::Sides<kind>::kCount> sides_;
  Memo<Vec3<Quadratic>> n_;
  Memo<RoughPolynomial<3 * degree>> volume_;
};

}  // namespace collided::exact
