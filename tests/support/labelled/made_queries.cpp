#include "tests/support/labelled/made_queries.hpp"

#include <algorithm>
#include <cmath>

namespace collided::test {
namespace {

bool in_frame(const mpq_class& t) { return t >= 0 && t <= 1; }

mpq_class determinant(const Frame3& f) {
  const auto& [u, w, q] = f;
  return u[0] * (w[1] * q[2] - w[2] * q[1]) + u[1] * (w[2] * q[0] - w[0] * q[2]) + u[2] * (w[0] * q[1] - w[1] * q[0]);
}

void set_hit(Made& made, bool meets, const mpq_class& t) {
  made.hit = meets && in_frame(t);
  made.first = t;
}

ExactVec within_plane(Dice& dice, const Frame3& f) {
  return dice.fraction(-1, 1, 3) * f.u + dice.fraction(-1, 1, 3) * f.w;
}

mpq_class power_of_two(int exponent) {
  mpq_class power(1);
  if (exponent >= 0) mpq_mul_2exp(power.get_mpq_t(), power.get_mpq_t(), static_cast<mp_bitcnt_t>(exponent));
  if (exponent < 0) mpq_div_2exp(power.get_mpq_t(), power.get_mpq_t(), static_cast<mp_bitcnt_t>(-exponent));
  return power;
}

}  // namespace

ExactVec operator+(const ExactVec& a, const ExactVec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
ExactVec operator-(const ExactVec& a, const ExactVec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
ExactVec operator*(const mpq_class& factor, const ExactVec& v) { return {factor * v[0], factor * v[1], factor * v[2]}; }

bool in_triangle(const mpq_class& x, const mpq_class& y) { return x >= 0 && y >= 0 && x + y <= 1; }
bool in_edge(const mpq_class& x) { return x >= 0 && x <= 1; }

uint64_t Dice::bits() {
  state_ += 0x9e3779b97f4a7c15ull;
  uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

int Dice::between(int low, int high) { return low + static_cast<int>(bits() % static_cast<uint64_t>(high - low + 1)); }

mpq_class Dice::fraction(int low, int high, int bits) {
  const int step = 1 << bits;
  mpq_class value(between(low * step, high * step), step);
  value.canonicalize();
  return value;
}

ExactVec Dice::vector(int size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

double Dice::real() { return static_cast<double>(bits() >> 11) * 0x1p-52 - 1; }

void Made::move_all(const ExactVec& by) {
  for (ExactVec& point : x) point = point + by;
}

void Made::add_velocity(const ExactVec& velocity) {
  for (ExactVec& own : v) own = own + velocity;
}

void Made::scale(int exponent) {
  const mpq_class factor = power_of_two(exponent);
  for (int i = 0; i < 4; ++i) {
    x[i] = factor * x[i];
    v[i] = factor * v[i];
  }
}

bool Made::to_query(Query& query) const {
  query.kind = kind;
  for (int i = 0; i < 8; ++i) {
    const ExactVec point = x[i % 4] + mpq_class(i / 4 - at) * v[i % 4];
    for (int k = 0; k < 3; ++k) {
      query.p[i][k] = point[k].get_d();
      if (!std::isfinite(query.p[i][k]) || mpq_class(query.p[i][k]) != point[k]) return false;
    }
  }
  return true;
}

Frame3 frame(Dice& dice, int size) {
  Frame3 f;
  do f = {dice.vector(size), dice.vector(size), dice.vector(size)};
  while (determinant(f) == 0);
  return f;
}

Made vertex_through_triangle(Dice& dice, const Frame3& f, const Crossing& c, bool deforms) {
  Made made{QueryKind::kVertexTriangle, c.t, {c.x * f.u + c.y * f.w, {}, f.u, f.w}, {f.q, {}, {}, {}}, false, {}};
  if (deforms)
    for (ExactVec& velocity : made.v) velocity = velocity + within_plane(dice, f);
  set_hit(made, in_triangle(c.x, c.y), c.t);
  return made;
}

Made edge_through_edge(Dice& dice, const Frame3& f, const Crossing& c, bool deforms) {
  Made made{QueryKind::kEdgeEdge, c.t,   {-c.x * f.u, mpq_class(1 - c.x) * f.u, -c.y * f.w, mpq_class(1 - c.y) * f.w},
            {f.q, f.q, {}, {}},   false, {}};
  if (deforms)
    for (ExactVec& velocity : made.v) velocity = velocity + within_plane(dice, f);
  set_hit(made, in_edge(c.x) && in_edge(c.y), c.t);
  return made;
}

Made parallel_edges(Dice& dice, const Frame3& f, const Crossing& c) {
  Made made{QueryKind::kEdgeEdge, c.t, {ExactVec{}, f.u, c.x * f.u, c.y * f.u}, {}, false, {}};
  const ExactVec sliding = dice.fraction(-1, 1, 3) * f.u;
  made.v = {f.q, f.q, sliding, sliding};
  set_hit(made, std::max(c.x, c.y) >= 0 && std::min(c.x, c.y) <= 1, c.t);
  return made;
}

Made vertex_within_plane(const Frame3& f, const Crossing& c) {
  Made made{QueryKind::kVertexTriangle, c.t, {c.x * f.u, {}, f.u, mpq_class(1, 2) * f.u - f.w}, {}, false, {}};
  made.v[0] = mpq_class(-1) * f.w;
  set_hit(made, in_edge(c.x), c.t);
  return made;
}

Made edge_within_plane(const Frame3& f, const Crossing& c) {
  Made made{QueryKind::kEdgeEdge, c.t, {c.x * f.u, c.x * f.u + f.w, {}, f.u}, {}, false, {}};
  made.v[0] = made.v[1] = mpq_class(-1) * f.w;
  set_hit(made, in_edge(c.x), c.t);
  return made;
}

// In the frame, with s = t - t*: the triangle is in the plane of q and (u + s w), where the w-coordinate is s times the
// u-coordinate. The vertex has the u-coordinate s and the w-coordinate depth, and so is depth - s^2 from it.
Made touching_turning(QueryKind kind, const Frame3& f, const mpq_class& t, const mpq_class& half, bool reaches) {
  const ExactVec side = mpq_class(2) * f.u, turn = mpq_class(2) * f.w, none{};
  const ExactVec reached = mpq_class((reaches ? 1 : -1) * half * half) * f.w;
  Made made;
  made.kind = kind;
  made.at = t;
  if (kind == QueryKind::kVertexTriangle) {
    made.x = {reached, none - side - f.q, side - f.q, f.q};
    made.v = {f.u, none - turn, turn, none};
  } else {
    made.x = {reached - f.q, reached + f.q, none - side, side};
    made.v = {f.u, f.u, none - turn, turn};
  }
  set_hit(made, reaches || half == 0, t - half);
  return made;
}

}  // namespace collided::test
