// From where a picture shows a scene.

#include "client/cli/picture/view.hpp"

#include <cmath>
#include <stdexcept>

#include "client/app/report/numbers.hpp"
#include "client/scenes/math.hpp"

namespace collided::cli {

namespace {

using scenes::Vec3d;

constexpr double kDegree = scenes::kPi / 180;
constexpr double kHalfAngle = 15 * kDegree;             // of view, along the shorter side of the picture
constexpr double kRim = 0.94;                           // part of the picture that is filled
constexpr double kNearest = 0.1;                        // of the scene's size, that the eye is before it
constexpr double kLargest = 1e100, kSmallest = 1e-100;  // sizes whose third powers are doubles

}  // namespace

std::array<Vec3d, 3> View::axes(const ViewOptions& options) {
  const double a = options.azimuth * kDegree, e = options.elevation * kDegree;
  // Towards the viewer and to the right, where z is up; at azimuth 0 the viewer is on the negative y axis.
  const Vec3d back{std::sin(a) * std::cos(e), -std::cos(a) * std::cos(e), std::sin(e)};
  const Vec3d right{std::cos(a), std::sin(a), 0};
  std::array<Vec3d, 3> axes{right, scenes::cross(back, right), scenes::times(back, -1)};
  if (options.is_y_up)
    for (Vec3d& axis : axes) axis = {axis[0], axis[2], -axis[1]};
  return axes;
}

std::array<double, 2> View::tangents(const ViewOptions& options) {
  const double pixel = std::tan(kHalfAngle) / std::min(options.width, options.height);
  return {pixel * options.width, pixel * options.height};
}

View::View(const ViewOptions& options, const Vec3d& eye, double middle_depth, double size)
    : axes_(axes(options)),
      width_(options.width),
      height_(options.height),
      middle_{eye[0], eye[1], middle_depth},
      scale_(2 / size),
      distance_(scale_ * (middle_depth - eye[2])),
      pixel_(2 * tangents(options)[0] / width_) {}

Vec3d View::direction_from_scene(const Vec3d& v) const {
  return {scenes::dot(axes_[0], v), scenes::dot(axes_[1], v), scenes::dot(axes_[2], v)};
}

Vec3d View::from_scene(const Vec3d& position) const {
  return scenes::times(scenes::minus(direction_from_scene(position), middle_), scale_);
}

Vec3d View::direction(double column, double row) const {
  return scenes::unit({pixel_ * (column - width_ / 2.0), pixel_ * (height_ / 2.0 - row), 1});
}

void Framing::add(const Vec3d& position) {
  Vec3d at;
  for (size_t i = 0; i < axes_.size(); ++i) {
    at[i] = scenes::dot(axes_[i], position);
    lower_[i] = std::min(lower_[i], at[i]);
    upper_[i] = std::max(upper_[i], at[i]);
  }
  for (size_t i = 0; i < sides_.size(); ++i)
    for (const size_t side : {size_t{0}, size_t{1}}) {
      const double across = (side == 0 ? at[i] : -at[i]) / (kRim * tangents_[i]);
      sides_[i][side] = std::max(sides_[i][side], across - at[2]);
    }
}

View Framing::view(double margin) const {
  if (is_empty()) return View(options_, {0, 0, -1 / tangents_[0]}, 0, 2);
  if (!(size() <= kLargest))  // an infinity, too
    throw std::runtime_error("the scene is too large for a picture: it has a size of " + format_double("%g", size()) +
                             "; the limit is " + format_double("%g", kLargest));
  if (size() + margin < kSmallest) return view(1);
  Vec3d eye{0, 0, lower_[2] - kNearest * size()};
  for (size_t i = 0; i < sides_.size(); ++i) {
    const double tangent = kRim * tangents_[i];
    eye[i] = tangent * (sides_[i][0] - sides_[i][1]) / 2;
    eye[2] = std::min(eye[2], -(sides_[i][0] + sides_[i][1]) / 2 - margin / tangent);
  }
  return View(options_, eye, (lower_[2] + upper_[2]) / 2, size() + 2 * margin);
}

}  // namespace collided::cli
