#include "tests/gpu/positions/exact_screw.hpp"

namespace collided::test {

ExactVec exact(const Vec3d& v) { return {exact(v[0]), exact(v[1]), exact(v[2])}; }
ExactVec operator+(const ExactVec& a, const ExactVec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
ExactVec operator-(const ExactVec& a, const ExactVec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
ExactVec operator*(const Exact& s, const ExactVec& a) { return {s * a[0], s * a[1], s * a[2]}; }
Exact dot(const ExactVec& a, const ExactVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
ExactVec cross(const ExactVec& a, const ExactVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Exact length(const ExactVec& a) { return sqrt(dot(a, a)); }
ExactVec unit(const ExactVec& a) { return (1 / length(a)) * a; }

double nearest(const Exact& x) {
  const double below = x.get_d();  // cut off
  return below + Exact(x - below).get_d();
}
Vec3d nearest(const ExactVec& a) { return {nearest(a[0]), nearest(a[1]), nearest(a[2])}; }

Angle::Angle(const Exact& radians) : sine(exact(0)), cosine(exact(0)) {
  Exact term = exact(1);
  for (int power = 0; power < 80; ++power) {
    (power % 2 == 0 ? cosine : sine) += term;
    term *= radians;
    term /= power % 2 == 0 ? power + 1 : -(power + 1);
    if (abs(term) <= 1e-72 * abs(sine)) break;
  }
}
ExactVec turned(const ExactVec& v, const ExactVec& axis, const Angle& angle) {
  const Exact along = dot(axis, v) * (1 - angle.cosine);
  return angle.cosine * v + angle.sine * cross(axis, v) + along * axis;
}

ExactScrew::Moment ExactScrew::at(double part) const {
  const Angle posed(posed_by), turn(part * angle);
  const auto image = [&](const ExactVec& v) { return turned(turned(v, posed_about, posed), axis, turn); };
  return {{image(exact(Vec3d{1, 0, 0})), image(exact(Vec3d{0, 1, 0})), image(exact(Vec3d{0, 0, 1}))},
          centre + (part * slide) * axis + turned(posed_at - centre, axis, turn)};
}
ExactVec ExactScrew::Moment::operator()(const ExactVec& p) const {
  return p[0] * columns[0] + p[1] * columns[1] + p[2] * columns[2] + t;
}
Pose ExactScrew::Moment::pose(const Vec3d& stretch) const {
  Pose pose;
  const Vec3d at = nearest(t);
  for (size_t k = 0; k < 3; ++k) {
    const Vec3d column = nearest((1 + exact(stretch[k])) * columns[k]);
    for (size_t i = 0; i < 3; ++i) pose.rows[4 * i + k] = column[i];
  }
  for (size_t i = 0; i < 3; ++i) pose.rows[4 * i + 3] = at[i];
  return pose;
}

}  // namespace collided::test
