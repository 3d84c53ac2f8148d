#pragma once
// Four numbers side by side on CPU cores, by the vector types of GCC and Clang: whatever vector unit there is. Each of
// them becomes what it would alone, to the last bit: an operation is the IEEE operation of each.

#include <cmath>

#include "gpu/base/choose.hpp"
#include "gpu/base/precision.hpp"
#include "gpu/base/vec3.hpp"

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace collided {

namespace detail {
template <class T>
struct VectorOfFour {
  // No more aligned than what malloc gives.
  typedef T Type __attribute__((vector_size(4 * sizeof(T)), aligned(16)));
};
template <class T>
struct SignedOf;
template <>
struct SignedOf<float> {
  using Type = int32_t;
};
template <>
struct SignedOf<double> {
  using Type = int64_t;
};
}  // namespace detail

/// Which of four numbers a condition holds for.
template <class T>
struct FourMask {
  typename detail::VectorOfFour<typename detail::SignedOf<T>::Type>::Type v;  ///< 0 or -1

  friend FourMask operator&(const FourMask& a, const FourMask& b) { return {a.v & b.v}; }
  friend FourMask operator|(const FourMask& a, const FourMask& b) { return {a.v | b.v}; }
  /// For formulas of one number, too: both sides are computed.
  friend FourMask operator&&(const FourMask& a, const FourMask& b) { return a & b; }
  friend FourMask operator||(const FourMask& a, const FourMask& b) { return a | b; }
  FourMask operator!() const { return {~v}; }
  /// Bit k: whether it holds for the k-th.
  uint32_t bits() const {
    uint32_t bits = 0;
    for (int k = 0; k < 4; ++k) bits |= static_cast<uint32_t>(v[k]) & 1u << k;
    return bits;
  }
};
#ifdef __SSE2__
template <>
inline uint32_t FourMask<float>::bits() const {
  return static_cast<uint32_t>(_mm_movemask_ps(reinterpret_cast<const __m128&>(v)));
}
#endif

template <class T>
struct Four {
  using Vector = typename detail::VectorOfFour<T>::Type;
  Vector v;

  Four() = default;
  constexpr Four(T x) : v{x, x, x, x} {}  // implicit: formulas have constants
  constexpr explicit Four(const Vector& lanes) : v(lanes) {}
  template <class U>
  explicit Four(const Four<U>& other) : v(__builtin_convertvector(other.v, Vector)) {}

  T operator[](int k) const { return v[k]; }
  void set(int k, T x) { v[k] = x; }

  friend Four operator+(const Four& a, const Four& b) { return Four(a.v + b.v); }
  friend Four operator-(const Four& a, const Four& b) { return Four(a.v - b.v); }
  friend Four operator*(const Four& a, const Four& b) { return Four(a.v * b.v); }
  friend Four operator/(const Four& a, const Four& b) { return Four(a.v / b.v); }
  friend FourMask<T> operator<(const Four& a, const Four& b) { return {a.v < b.v}; }
  friend FourMask<T> operator>(const Four& a, const Four& b) { return {a.v > b.v}; }
  friend FourMask<T> operator<=(const Four& a, const Four& b) { return {a.v <= b.v}; }
  friend FourMask<T> operator>=(const Four& a, const Four& b) { return {a.v >= b.v}; }
  friend FourMask<T> operator==(const Four& a, const Four& b) { return {a.v == b.v}; }
  friend FourMask<T> operator!=(const Four& a, const Four& b) { return {a.v != b.v}; }
};

template <class T>
struct NumberTraits<Four<T>> {
  using Mask = FourMask<T>;
  using Double = Four<double>;
};
template <class T>
struct Precision<Four<T>> : Precision<T> {};

template <class T>
bool any(const FourMask<T>& is) {
  return is.bits() != 0;
}
template <class T>
bool all(const FourMask<T>& is) {
  return is.bits() == 0xf;
}
template <class T>
Four<T> select(const FourMask<T>& is, const Four<T>& a, const Four<T>& b) {
  return Four<T>(is.v ? a.v : b.v);
}
template <class T>
Vec3<Four<T>> select(const FourMask<T>& is, const Vec3<Four<T>>& a, const Vec3<Four<T>>& b) {
  return {select(is, a.x, b.x), select(is, a.y, b.y), select(is, a.z, b.z)};
}
template <class N, class T, class F>
T replace_where(const FourMask<N>& is, const T& value, const F& f) {
  return select(is, f(), value);
}

// As for one number (vec3.hpp, precision.hpp).
template <class T>
Four<T> min(const Four<T>& a, const Four<T>& b) {
  return Four<T>(b.v < a.v ? b.v : a.v);
}
template <class T>
Four<T> max(const Four<T>& a, const Four<T>& b) {
  return Four<T>(a.v < b.v ? b.v : a.v);
}
template <class T>
Four<T> magnitude(const Four<T>& a) {
  using Bits = typename detail::VectorOfFour<typename detail::SignedOf<T>::Type>::Type;
  constexpr auto kRest = static_cast<typename detail::SignedOf<T>::Type>(~detail::Bits<T>::kSign);
  return Four<T>((typename Four<T>::Vector)((Bits)a.v & kRest));
}
inline Four<float> square_root(const Four<float>& a) {
#ifdef __SSE2__
  return Four<float>(reinterpret_cast<Four<float>::Vector>(_mm_sqrt_ps(reinterpret_cast<const __m128&>(a.v))));
#else
  return Four<float>(Four<float>::Vector{std::sqrt(a.v[0]), std::sqrt(a.v[1]), std::sqrt(a.v[2]), std::sqrt(a.v[3])});
#endif
}
template <class T>
Four<T> unit_scale(const Four<T>& x) {
  using Bits = typename detail::VectorOfFour<typename detail::Bits<T>::Type>::Type;
  constexpr int kMantissa = sizeof(T) == 4 ? 23 : 52;
  constexpr typename detail::Bits<T>::Type kTwice = sizeof(T) == 4 ? 254 : 2046;  // the exponent of 1, doubled
  return Four<T>((typename Four<T>::Vector)((kTwice - ((Bits)x.v >> kMantissa)) << kMantissa));
}
inline Four<float> float_above(const Four<double>& x) {
  Four<float> out;
  for (int k = 0; k < 4; ++k) out.set(k, float_above(x[k]));
  return out;
}
/// thickness * scale for each scale.
template <class Work>
Four<Work> scaled_thickness(double thickness, const Four<double>& scale) {
  Four<Work> out = 0;
  if (thickness > 0)
    for (int k = 0; k < 4; ++k) out.set(k, scaled_thickness<Work>(thickness, scale[k]));
  return out;
}
/// The same of four thicknesses. Work is four of the working type.
template <class Work>
Work scaled_thickness(const Four<double>& thickness, const Four<double>& scale) {
  Work out;
  for (int k = 0; k < 4; ++k) out.set(k, scaled_thickness<float>(thickness[k], scale[k]));
  return out;
}

}  // namespace collided
