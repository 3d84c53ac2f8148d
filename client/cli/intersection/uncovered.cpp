// Parts of a mesh of which no contact tells whether they meet each other.

#include "client/cli/intersection/uncovered.hpp"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>

#include "client/app/report/numbers.hpp"
#include "client/scenes/vec3.hpp"

namespace collided::cli {

namespace {

namespace mp = boost::multiprecision;
/// Holds products of two differences of doubles in units of the smallest one's last bit: 2 * 2,100 bits.
using Integer = mp::number<mp::cpp_int_backend<4224, 4224, mp::signed_magnitude, mp::unchecked, void>>;
using Point = std::array<double, 3>;

constexpr int kFractionBits = 53, kSmallestBit = -1074;

/// A power of two of which a double other than 0 is a whole multiple, by less than 2^53.
int last_bit(double x) {
  int exponent = 0;
  std::frexp(x, &exponent);
  return std::max(exponent - kFractionBits, kSmallestBit);
}

/// x in units of 2^unit; unit is at most its last bit.
Integer integer(double x, int unit) {
  if (x == 0) return 0;
  const int bit = last_bit(x);
  return Integer(static_cast<int64_t>(std::ldexp(x, -bit))) << (bit - unit);
}

/// True if the twofold area of the projection along an axis is surely not 0. Errors of the differences and products are
/// below 2^-51 of the products; far numbers are left to exact arithmetic, whose products overflow or vanish.
bool is_surely_clear(const Point& u, const Point& v, size_t axis) {
  const size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double p = u[i] * v[j], q = u[j] * v[i];
  return std::abs(p - q) > 0x1p-48 * (std::abs(p) + std::abs(q)) && std::abs(p - q) > 0x1p-900 &&
         std::abs(p - q) < 0x1p900;
}

bool has_exact_area(const Point& a, const Point& b, const Point& c) {
  int unit = 1024;
  for (const Point& p : {a, b, c})
    for (const double x : p)
      if (x != 0) unit = std::min(unit, last_bit(x));
  std::array<Integer, 3> u, v;
  for (size_t axis = 0; axis < 3; ++axis) {
    const Integer origin = integer(a[axis], unit);
    u[axis] = integer(b[axis], unit) - origin;
    v[axis] = integer(c[axis], unit) - origin;
  }
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = (i + 1) % 3;
    if (u[i] * v[j] != u[j] * v[i]) return true;
  }
  return false;
}

/// "2 triangles without area, the first 17".
std::string sentence(uint64_t count, const std::string& what, uint32_t first) {
  return count_text(count) + (count == 1 ? " triangle " : " triangles ") + what + ", " +
         (count == 1 ? "" : "the first ") + std::to_string(first);
}

/// Triangles that have the same corners as one before.
std::vector<uint32_t> repeated(std::span<const std::array<uint32_t, 3>> triangles) {
  std::vector<std::array<uint32_t, 4>> keys;
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    std::array<uint32_t, 3> corners = triangles[i];
    std::ranges::sort(corners);
    keys.push_back({corners[0], corners[1], corners[2], i});
  }
  std::ranges::sort(keys);
  std::vector<uint32_t> out;
  for (size_t k = 1; k < keys.size(); ++k)
    if (std::equal(keys[k].begin(), keys[k].begin() + 3, keys[k - 1].begin())) out.push_back(keys[k][3]);
  std::ranges::sort(out);
  return out;
}

}  // namespace

bool has_area(const Point& a, const Point& b, const Point& c) {
  const Point u = scenes::minus(b, a), v = scenes::minus(c, a);
  for (size_t axis = 0; axis < 3; ++axis)
    if (is_surely_clear(u, v, axis)) return true;
  return has_exact_area(a, b, c);
}

std::vector<std::string> uncovered_parts(const client::MeshInput& mesh, client::Positions positions) {
  std::vector<std::string> out;
  std::vector<uint32_t> flat;
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    if (!has_area(positions[a], positions[b], positions[c])) flat.push_back(i);
  }
  if (!flat.empty()) out.push_back(sentence(flat.size(), "without area", flat.front()));
  if (const std::vector<uint32_t> again = repeated(mesh.triangles); !again.empty())
    out.push_back(sentence(again.size(), "listed again", again.front()));
  if (const size_t loose = mesh.edges.size() + mesh.points.size(); loose > 0)
    out.push_back(count_text(loose) + (loose == 1 ? " loose edge or point" : " loose edges and points"));
  return out;
}

}  // namespace collided::cli
