#include "gpu/exact/roots/rough.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "gpu/exact/fixed/motion.hpp"

namespace collided::exact {
namespace {

constexpr int kUnknown = RoughForm::kUnknown;
/// Sums here have up to seven terms. Each is a product of a coefficient, two binomials and up to six factors, with one
/// rounding each, so that sums are within 2^-46 of their terms' magnitudes.
constexpr double kError = 0x1p-45;

constexpr int kBinomials[7][7] = {
    {1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}, {1, 6, 15, 20, 15, 6, 1}};

/// Returns where to cut an interval in two. Constructed input has its roots in the middle, so the cut lies beside it.
double cut_of(double begin, double end) {
  return end > 4 * begin ? std::sqrt(begin) * std::sqrt(end) * 1.0078125 : begin + (end - begin) * 0.4921875;
}

int certain_sign(double sum, double size) { return sum > kError * size ? 1 : sum < -kError * size ? -1 : kUnknown; }

}  // namespace

std::optional<RoughForm> RoughForm::of(const Form& f) {
  if (f.c.size() > kMostCoefficients) return std::nullopt;
  RoughForm rough;
  rough.degree_ = static_cast<int>(f.degree());
  for (size_t i = 0; i < f.c.size(); ++i) rough.c_[i] = f.c[i].to_double(rough.exponent_[i]);
  return rough;
}

bool RoughForm::set(size_t i, const RoughNumber& c) {
  if (!(magnitude(c.value) >= kKnownShare * c.size)) return false;
  int exponent = 0;
  c_[i] = static_cast<double>(std::frexp(c.value, &exponent));
  exponent_[i] = exponent;
  return true;
}

RoughForm RoughForm::without_roots_at_ends() const {
  size_t first = 0, last = static_cast<size_t>(degree_);
  while (c_[first] == 0) ++first;
  while (c_[last] == 0) --last;
  RoughForm f;
  f.degree_ = static_cast<int>(last - first);
  for (size_t i = first; i <= last; ++i) f.c_[i - first] = c_[i], f.exponent_[i - first] = exponent_[i];
  return f;
}

bool RoughForm::vanishes() const {
  return std::all_of(c_.begin(), c_.end(), [](double x) { return x == 0; });
}

// Terms i and j are of one size at x = 2^((e_i - e_j) / (j - i)). Away from the edges of the polygon by 11 in the
// exponent the largest term is above the sum of all others: each is below it by a factor of 2^10 for each step.
std::optional<std::vector<RoughForm::Neighbourhood>> RoughForm::neighbourhoods() const {
  constexpr int64_t kReach = 12, kLongest = 140;  // sixth powers are doubles
  std::vector<Neighbourhood> places;
  std::optional<std::pair<int64_t, int64_t>> open;
  const auto close = [&] {
    const int64_t scale = (open->first + open->second) / 2;
    places.push_back({scale, static_cast<int>(open->second - scale)});
    return open->second - open->first <= kLongest;
  };
  // The upper hull from the last term to the first: x grows, and larger powers win.
  for (int i = 0; i < degree_;) {
    int next = 0;
    int64_t at = 0;
    for (int j = i + 1; j <= degree_; ++j) {
      if (c_[static_cast<size_t>(j)] == 0) continue;
      const int64_t rise = exponent_[static_cast<size_t>(i)] - exponent_[static_cast<size_t>(j)], steps = j - i;
      const int64_t where = rise >= 0 ? rise / steps : -((-rise + steps - 1) / steps);
      if (next == 0 || where <= at) next = j, at = where;
    }
    if (open && at - kReach > open->second) {
      if (!close()) return std::nullopt;
      open.reset();
    }
    if (!open) open = {at - kReach, at + kReach};
    open = {std::min(open->first, at - kReach), std::max(open->second, at + kReach)};
    i = next;
  }
  if (open && !close()) return std::nullopt;
  return places;
}

int RoughForm::largest_term(int64_t scale) const {
  constexpr int64_t kClearly = 6;  // coefficients are above 1/2: six others are below 6/32
  const auto exponent = [&](int i) { return exponent_[static_cast<size_t>(i)] + scale * i; };
  int largest = -1;
  for (int i = 0; i <= degree_; ++i)
    if (c_[static_cast<size_t>(i)] != 0 && (largest < 0 || exponent(i) > exponent(largest))) largest = i;
  for (int i = 0; i <= degree_; ++i)
    if (i != largest && c_[static_cast<size_t>(i)] != 0 && exponent(i) + kClearly > exponent(largest)) return -1;
  return largest;
}

// A term that is the largest at both ends is so between them, as the terms' logarithms are lines in that of x.
int RoughForm::sign_on(const Place& begin, const Place& end) const {
  constexpr int64_t kLongest = 100;
  if (const int term = largest_term(begin.scale); term >= 0 && term == largest_term(end.scale + 1))
    return c_[static_cast<size_t>(term)] > 0 ? 1 : -1;
  if (end.scale - begin.scale > kLongest) return kUnknown;
  const int64_t scale = begin.scale + (end.scale - begin.scale) / 2;
  const auto at = [&](const Place& p) { return std::ldexp(p.y, static_cast<int>(p.scale - scale)); };
  return at_scale(scale).sign_on(at(begin), at(end));
}

int RoughForm::sign_at(const Place& at) const {
  if (const int term = largest_term(at.scale); term >= 0 && term == largest_term(at.scale + 1))
    return c_[static_cast<size_t>(term)] > 0 ? 1 : -1;
  return at_scale(at.scale).sign_at(at.y);
}

// Where one term is the largest, all others together are below 3/8 of it.
RoughForm::Range RoughForm::range_on(const Place& begin, const Place& end) const {
  if (vanishes()) return {0, {}, {}};
  constexpr int64_t kLongest = 100;
  if (const int term = largest_term(begin.scale); term >= 0 && term == largest_term(end.scale + 1)) {
    const auto i = static_cast<size_t>(term);
    const double size = std::abs(c_[i]);
    return {c_[i] > 0 ? 1 : -1,
            {size * 0.625, exponent_[i] + begin.scale * term},
            {size * 1.375, exponent_[i] + (end.scale + 1) * term}};
  }
  const int64_t scales = end.scale - begin.scale;
  if (scales > kLongest) return {kUnknown, {}, {1, std::numeric_limits<int64_t>::max() / 4}};
  const int64_t scale = begin.scale + scales / 2;
  const auto at = [&](const Place& p) { return std::ldexp(p.y, static_cast<int>(p.scale - scale)); };
  const Local local = at_scale(scale);
  Range range{};
  const auto [low, high] = local.magnitudes_on(at(begin), at(end), range.sign);
  range.low = {low, local.top_}, range.high = {high, local.top_};
  return range;
}

RoughForm::Local RoughForm::at_scale(int64_t scale) const {
  constexpr int64_t kSmallest = -1000;  // far below the error of the largest term
  Local local;
  local.degree_ = degree_;
  int64_t top = std::numeric_limits<int64_t>::min();
  const auto exponent = [&](int i) { return exponent_[static_cast<size_t>(i)] + scale * i; };
  for (int i = 0; i <= degree_; ++i)
    if (c_[static_cast<size_t>(i)] != 0) top = std::max(top, exponent(i));
  local.top_ = top;
  for (int i = 0; i <= degree_; ++i) {
    const double c = c_[static_cast<size_t>(i)];
    if (c == 0) continue;
    const int64_t below = exponent(i) - top;
    local.c_[static_cast<size_t>(i)] = below < kSmallest ? 0 : std::ldexp(c, static_cast<int>(below));
  }
  return local;
}

int RoughForm::Local::sign_at(double y) const {
  double sum = 0, size = 0;
  for (int i = degree_; i >= 0; --i) {
    const double c = c_[static_cast<size_t>(i)];
    sum = sum * y + c;
    size = size * y + std::abs(c);
  }
  return certain_sign(sum, size);
}

template <class Use>
void RoughForm::Local::for_coefficients_on(double begin, double end, const Use& use) const {
  double a[kMostCoefficients], b[kMostCoefficients];
  a[0] = b[0] = 1;
  for (int i = 1; i <= degree_; ++i) a[i] = a[i - 1] * begin, b[i] = b[i - 1] * end;
  for (int j = 0; j <= degree_; ++j) {
    double sum = 0, size = 0;
    for (int k = 0; k <= degree_; ++k) {
      double weight = 0;
      for (int i = std::max(0, j - degree_ + k); i <= std::min(j, k); ++i)
        weight += kBinomials[k][i] * kBinomials[degree_ - k][j - i] * a[k - i] * b[i];
      const double term = c_[static_cast<size_t>(k)] * weight;
      sum += term;
      size += std::abs(term);
    }
    use(j, sum, size);
  }
}

RoughForm::Local::Signs RoughForm::Local::signs_on(double begin, double end) const {
  Signs signs{};
  for_coefficients_on(begin, end,
                      [&](int j, double sum, double size) { signs[static_cast<size_t>(j)] = certain_sign(sum, size); });
  return signs;
}

// Values are between the least and the greatest coefficient over its binomial.
std::pair<double, double> RoughForm::Local::magnitudes_on(double begin, double end, int& sign) const {
  double least = std::numeric_limits<double>::infinity(), greatest = -least;
  for_coefficients_on(begin, end, [&](int j, double sum, double size) {
    const double by = 1.0 / kBinomials[degree_][j], error = kError * size;
    least = std::min(least, (sum - error) * by);
    greatest = std::max(greatest, (sum + error) * by);
  });
  constexpr double kLess = 1 - 0x1p-50, kMore = 1 + 0x1p-50;
  sign = least > 0 ? 1 : greatest < 0 ? -1 : kUnknown;
  return {sign == kUnknown ? 0 : std::min(std::abs(least), std::abs(greatest)) * kLess,
          std::max(std::abs(least), std::abs(greatest)) * kMore};
}

int RoughForm::Local::sign_on(double begin, double end) const {
  const Signs signs = signs_on(begin, end);
  const bool agree = std::all_of(signs.begin(), signs.begin() + degree_ + 1, [&](int s) { return s == signs[0]; });
  return agree ? signs[0] : kUnknown;
}

int RoughForm::Local::changes_on(double begin, double end, int& first) const {
  const Signs signs = signs_on(begin, end);
  first = signs[0];
  int changes = 0;
  for (int i = 0; i <= degree_; ++i) {
    if (signs[static_cast<size_t>(i)] == kUnknown) return kUnknown;
    changes += i > 0 && signs[static_cast<size_t>(i)] != signs[static_cast<size_t>(i - 1)] ? 1 : 0;
  }
  return changes;
}

bool RoughRoot::refine(int times) {
  for (; times > 0; --times) {
    const double cut = cut_of(begin_, end_);
    const int sign = f_.sign_at(cut);
    if (sign == kUnknown) return false;
    (sign == left_sign_ ? begin_ : end_) = cut;
  }
  return true;
}

int RoughRoot::sign_of(const RoughForm& g) {
  if (g.vanishes()) return 0;
  const RoughForm::Local local = g.at_scale(scale_);
  constexpr double kShortest = 0x1p-44;
  while (end_ - begin_ > kShortest * begin_) {
    if (const int sign = local.sign_on(begin_, end_); sign != kUnknown) return sign;
    if (!refine(4)) return kUnknown;
  }
  return kUnknown;
}

double ratio_of(const RoughForm::Place& at) {
  return std::ldexp(at.y, static_cast<int>(std::clamp<int64_t>(at.scale, -500, 500)));
}

// Near 1, the time that is left until then has more correct bits.
std::optional<double> rounded_time(double low, double high) {
  constexpr double kLess = 1 - 0x1p-50, kMore = 1 + 0x1p-50;
  if (high < 0x1p-61) return 0;
  if (low > 0x1p61) return fixed::time_of(fixed::kOne - 1);
  const auto time = [](double x) {
    if (x < 0x1p-100) return 0.0;
    if (x < 1) return fixed::time_of(static_cast<uint64_t>(x / (1 + x) * 0x1p60));
    return fixed::time_of(fixed::kOne - static_cast<uint64_t>(std::ceil(1 / (1 + x) * 0x1p60)));
  };
  const double first = time(low * kLess), last = time(high * kMore);
  return first == last ? std::optional(first) : std::nullopt;
}

bool RoughRoot::is_within(const RoughForm::Place& from, const RoughForm::Place& to) {
  constexpr int64_t kFar = 500;
  const auto place = [&](const RoughForm::Place& p) {
    return std::ldexp(p.y, static_cast<int>(std::clamp<int64_t>(p.scale - scale_, -kFar, kFar)));
  };
  const double low = place(from), high = place(to);
  while (begin_ < high && end_ > low) {
    if (begin_ >= low && end_ <= high) return true;
    if (!refine(1)) break;
  }
  return false;
}

std::optional<double> RoughRoot::rounded_down() {
  while (end_ - begin_ > 0x1p-40 * begin_ && refine(1)) {
  }
  return rounded_time(ratio(begin_), ratio(end_));
}

std::optional<Root> RoughRoot::exact(const Form& f) const {
  constexpr int64_t kFarthest = 4000;
  if (scale_ < -kFarthest || scale_ > kFarthest) return std::nullopt;
  // t, or the time that is left, is about 2^-|scale|, and known to some 44 bits.
  mp_bitcnt_t bits = static_cast<mp_bitcnt_t>(std::abs(scale_)) + 44;
  const auto time = [&](double y) {
    int exponent = 0;
    const auto mantissa = static_cast<int64_t>(std::ldexp(std::frexp(y, &exponent), 53));
    const int64_t shift = scale_ + exponent - 53;
    const Number t = shift > 0 ? Number(mantissa) << static_cast<mp_bitcnt_t>(shift) : Number(mantissa),
                 s = shift < 0 ? Number(1) << static_cast<mp_bitcnt_t>(-shift) : Number(1);
    return (t << bits) / (s + t);
  };
  Number first = time(begin_), last = time(end_);
  for (; bits > 0 && !(first == last); --bits) first >>= 1, last >>= 1;
  const Dyadic in{first, bits};
  const Form local = restricted(f, in);
  if (sign_changes(local) != 1) return std::nullopt;
  return Root::inside(f, in, first_sign(local));
}

std::optional<std::vector<RoughRoot>> rough_roots(const RoughForm& f) {
  if (f.degree() == 0) return std::nullopt;
  const auto places = f.neighbourhoods();
  if (!places) return std::nullopt;
  std::vector<RoughRoot> roots;
  for (const RoughForm::Neighbourhood& place : *places) {
    const RoughForm::Local local = f.at_scale(place.scale);
    std::vector<std::pair<double, double>> left_to_right{{std::ldexp(1, -place.reach), std::ldexp(1, place.reach)}};
    while (!left_to_right.empty()) {
      const auto [begin, end] = left_to_right.back();
      left_to_right.pop_back();
      int first = 0;
      const int changes = local.changes_on(begin, end, first);
      if (changes == 0) continue;
      if (changes == 1) {
        roots.emplace_back(local, place.scale, begin, end, first);
        continue;
      }
      constexpr double kShortest = 0x1p-20;
      if (!(end - begin > kShortest * begin)) return std::nullopt;
      const double cut = cut_of(begin, end);
      left_to_right.emplace_back(cut, end);
      left_to_right.emplace_back(begin, cut);
    }
  }
  return roots;
}

}  // namespace collided::exact
