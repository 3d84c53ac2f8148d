// Positions as they go on the wire.

#include "client/cpp/positions.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>

#include "client/cpp/error.hpp"

namespace collided::client {

namespace {

constexpr int kInvalidArgument = 3;

/// Describes a format.
struct FormatRow {
  v1::PositionFormat format;
  uint64_t bytes;  ///< of one vertex's position
  bool is_double, is_quantized;
};

constexpr FormatRow kFormats[] = {
    {v1::POSITION_FORMAT_UNSPECIFIED, 3 * sizeof(float), false, false},  // F32
    {v1::POSITION_FORMAT_F32, 3 * sizeof(float), false, false},
    {v1::POSITION_FORMAT_F64, 3 * sizeof(double), true, false},
    {v1::POSITION_FORMAT_Q16, 3 * sizeof(uint16_t), false, true},
};
static_assert(std::size(kFormats) == v1::PositionFormat_ARRAYSIZE, "a format of positions has no row");

/// Null for a format of a later protocol.
const FormatRow* row_of(v1::PositionFormat format) {
  const auto* const row = std::find_if(std::begin(kFormats), std::end(kFormats),
                                       [&](const FormatRow& known) { return known.format == format; });
  return row == std::end(kFormats) ? nullptr : row;
}

[[noreturn]] void refuse(v1::PositionFormat format) {
  throw Error(kInvalidArgument, "position format " + std::to_string(format) + " is not F32 or F64" +
                                    (is_quantized(format) ? "; pack_quantized is for Q16" : ""));
}

std::string pack_f32(Positions positions) {
  std::string out(positions.size() * 3 * sizeof(float), '\0');
  char* to = out.data();
  for (const auto& p : positions) {
    const std::array<float, 3> f{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
    std::memcpy(to, f.data(), sizeof f);
    to += sizeof f;
  }
  return out;
}

void check_sizes(size_t positions, size_t target) {
  if (positions != target)
    throw Error(kInvalidArgument,
                "target has " + std::to_string(target) + " coordinates, positions have " + std::to_string(positions));
}

void check_whole(size_t coordinates) {
  if (coordinates % 3 != 0)
    throw Error(kInvalidArgument,
                "positions have " + std::to_string(coordinates) + " coordinates, which is no multiple of 3");
}

void check_fraction(double fraction) {
  if (!(fraction >= 0 && fraction <= 1))
    throw Error(kInvalidArgument, "fraction is " + std::to_string(fraction) + "; it must be from 0 to 1");
}

template <class Real>
void move(std::span<Real> positions, std::span<const Real> target, double fraction) {
  check_sizes(positions.size(), target.size());
  check_fraction(fraction);
  if (fraction == 0) return;
  for (size_t i = 0; i < positions.size(); ++i) {
    const double x = positions[i], way = target[i] - x, part = fraction * way;
    positions[i] = fraction == 1 ? target[i] : static_cast<Real>(x + part);
  }
}

template <class Real>
void move(std::span<Real> positions, std::span<const Real> target, const FrameAdvance& advance, uint32_t mesh,
          uint32_t first_vertex) {
  check_sizes(positions.size(), target.size());
  check_whole(positions.size());
  if (advance.mode != v1::ADVANCE_MODE_PER_VERTEX)
    return move(positions, target, advance.of_vertex(mesh, first_vertex));
  size_t next = 0;  // of the coordinates
  const auto move_until = [&](size_t end, double fraction) {
    move(positions.subspan(next, end - next), target.subspan(next, end - next), fraction);
    next = end;
  };
  const std::vector<uint32_t>& ids = advance.ids;
  for (auto id = std::lower_bound(ids.begin(), ids.end(), first_vertex); id != ids.end(); ++id) {
    const size_t at = 3 * size_t{*id - first_vertex};
    if (at >= positions.size()) break;
    move_until(at, 1);
    move_until(at + 3, advance.fractions[static_cast<size_t>(id - ids.begin())]);
  }
  move_until(positions.size(), 1);
}

/// With all its digits.
std::string text(double x) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.17g", x);
  return digits;
}

/// One axis of a box that positions are encoded in.
struct Axis {
  double lower, upper, step;

  uint16_t encode(double x, size_t vertex, char name) const {
    constexpr double kLast = 65535;
    if (!(x >= lower && x <= upper))
      throw Error(kInvalidArgument, "vertex " + std::to_string(vertex) + ": " + name + " is " + text(x) +
                                        ", outside the box, " + text(lower) + " to " + text(upper));
    return step > 0 ? static_cast<uint16_t>(std::fmin(std::round((x - lower) / step), kLast)) : uint16_t{0};
  }
};

std::array<Axis, 3> axes_of(const v1::QuantizationBox& box) {
  if (box.lower_size() != 3 || box.upper_size() != 3)
    throw Error(kInvalidArgument, "the box has " + std::to_string(box.lower_size()) + " and " +
                                      std::to_string(box.upper_size()) + " coordinates, 3 each are needed");
  std::array<Axis, 3> axes;
  for (int k = 0; k < 3; ++k) {
    const double lower = box.lower(k), upper = box.upper(k);
    if (!(std::isfinite(lower) && std::isfinite(upper) && lower <= upper))
      throw Error(kInvalidArgument,
                  "the box is from " + text(lower) + " to " + text(upper) + "; both must be finite and in order");
    axes[static_cast<size_t>(k)] = {lower, upper, (upper - lower) / 65535};
  }
  return axes;
}

template <class Pack>
v1::MeshUpdate update_of(uint32_t mesh, Positions positions, Positions start, const Pack& pack) {
  v1::MeshUpdate update;
  update.set_mesh(mesh);
  update.set_positions(pack(positions));
  if (!start.empty()) update.set_start_positions(pack(start));
  return update;
}

std::string bytes_of(const RigidMatrix& matrix) {
  return {reinterpret_cast<const char*>(matrix.data()), sizeof(matrix)};
}

template <class Real>
void move_all(std::span<Real> positions, const RigidMatrix& m) {
  check_whole(positions.size());
  for (size_t i = 0; i < positions.size(); i += 3) {
    const double x = positions[i], y = positions[i + 1], z = positions[i + 2];
    for (size_t row = 0; row < 3; ++row) {
      const double* r = &m[4 * row];
      positions[i + row] = static_cast<Real>(((r[0] * x + r[1] * y) + r[2] * z) + r[3]);
    }
  }
}

using Vec = std::array<double, 3>;

/// A column of [R | t], 0 to 3.
Vec column(const RigidMatrix& m, size_t k) { return {m[k], m[4 + k], m[8 + k]}; }
Vec plus(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec times(double s, const Vec& a) { return {s * a[0], s * a[1], s * a[2]}; }
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The rotation from one pose to another as a unit quaternion, c and v.
struct HalfTurn {
  double c;
  Vec v;

  HalfTurn(const RigidMatrix& from, const RigidMatrix& to) {
    double cosine = 1;
    Vec sine{};
    for (size_t k = 0; k < 3; ++k) {
      const Vec a = column(from, k), b = column(to, k);
      cosine += dot(a, b);
      sine = plus(sine, cross(a, minus(b, a)));
    }
    if (!(cosine > 0 && std::isfinite(cosine)))
      throw Error(kInvalidArgument,
                  "the rotations of the poses are half a turn apart or not finite; they must turn by less");
    const double length = std::sqrt(cosine * cosine + dot(sine, sine));
    c = cosine / length, v = times(1 / length, sine);
  }
  Vec turn(double along, double across, double turned, const Vec& x) const {
    return plus(times(along, x), plus(times(across * dot(v, x), v), times(turned, cross(v, x))));
  }
};

}  // namespace

// The names are those of proto/CONVENTIONS.md.
RigidMatrix pose_along(const RigidMatrix& from, const RigidMatrix& to, double fraction) {
  check_fraction(fraction);
  if (fraction == 0) return from;
  if (fraction == 1) return to;
  const double f = fraction;
  const HalfTurn half(from, to);
  const double c = half.c, q = dot(half.v, half.v), m = 2 * f - 1, of_middle = 1 - (m * m) * q,
               h = 2 * (f * (1 - f)) / (c + std::sqrt(of_middle > 0 ? of_middle : 0)), s = f * c + h * q, r = f - h * c;
  RigidMatrix pose;
  const auto put = [&](size_t k, const Vec& x) { pose[k] = x[0], pose[4 + k] = x[1], pose[8 + k] = x[2]; };
  for (size_t k = 0; k < 3; ++k) {
    const Vec a = column(from, k), back = half.turn(1 - 2 * q, 2, -2 * c, column(to, k));
    put(k, half.turn(1 - 2 * (r * q), 2 * r, 2 * s, plus(a, times(f, minus(back, a)))));
  }
  const Vec t = column(from, 3), way = minus(column(to, 3), t);
  put(3, plus(t, plus(times(f, way), times(h, cross(way, half.v)))));
  return pose;
}

std::string pack_quantized(Positions positions, const v1::QuantizationBox& box) {
  const std::array<Axis, 3> axes = axes_of(box);
  std::string out(positions.size() * 3 * sizeof(uint16_t), '\0');
  for (size_t i = 0; i < positions.size(); ++i)
    for (size_t k = 0; k < 3; ++k) {
      const uint16_t q = axes[k].encode(positions[i][k], i, "xyz"[k]);
      std::memcpy(&out[(3 * i + k) * sizeof(q)], &q, sizeof(q));
    }
  return out;
}

v1::MeshUpdate rigid_update(uint32_t mesh, const RigidMatrix& matrix) {
  v1::MeshUpdate update;
  update.set_mesh(mesh);
  update.mutable_rigid()->set_matrix(bytes_of(matrix));
  return update;
}
v1::MeshUpdate rigid_update(uint32_t mesh, const RigidMatrix& matrix, const RigidMatrix& start) {
  v1::MeshUpdate update = rigid_update(mesh, matrix);
  update.mutable_rigid()->set_start_matrix(bytes_of(start));
  return update;
}

void move_rigidly(std::span<float> positions, const RigidMatrix& matrix) { move_all(positions, matrix); }
void move_rigidly(std::span<double> positions, const RigidMatrix& matrix) { move_all(positions, matrix); }

void move_along(std::span<float> positions, std::span<const float> target, double fraction) {
  move(positions, target, fraction);
}
void move_along(std::span<double> positions, std::span<const double> target, double fraction) {
  move(positions, target, fraction);
}

void move_along(std::span<float> positions, std::span<const float> target, const FrameAdvance& advance, uint32_t mesh,
                uint32_t first_vertex) {
  move(positions, target, advance, mesh, first_vertex);
}
void move_along(std::span<double> positions, std::span<const double> target, const FrameAdvance& advance, uint32_t mesh,
                uint32_t first_vertex) {
  move(positions, target, advance, mesh, first_vertex);
}

uint64_t position_bytes(v1::PositionFormat format) {
  const FormatRow* const row = row_of(format);
  if (!row) refuse(format);
  return row->bytes;
}

bool is_double(v1::PositionFormat format) {
  const FormatRow* const row = row_of(format);
  return row && row->is_double;
}

bool is_quantized(v1::PositionFormat format) {
  const FormatRow* const row = row_of(format);
  return row && row->is_quantized;
}

std::string pack_positions(Positions positions, v1::PositionFormat format) {
  const FormatRow* const row = row_of(format);
  if (!row || row->is_quantized) refuse(format);
  return row->is_double ? std::string(reinterpret_cast<const char*>(positions.data()), positions.size_bytes())
                        : pack_f32(positions);
}

v1::MeshUpdate mesh_update(uint32_t mesh, v1::PositionFormat format, Positions positions, Positions start) {
  return update_of(mesh, positions, start, [&](Positions some) { return pack_positions(some, format); });
}
v1::MeshUpdate mesh_update(uint32_t mesh, const v1::SceneSpec& spec, Positions positions, Positions start) {
  if (!is_quantized(spec.position_format())) return mesh_update(mesh, spec.position_format(), positions, start);
  return update_of(mesh, positions, start,
                   [&](Positions some) { return pack_quantized(some, spec.quantization_box()); });
}

}  // namespace collided::client
