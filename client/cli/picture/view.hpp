#pragma once
// From where a picture shows a scene.

#include <algorithm>
#include <array>
#include <limits>

#include "client/scenes/vec3.hpp"

namespace collided::cli {

struct ViewOptions {
  double azimuth = 30, elevation = 25;  ///< degrees, of the viewer: around the upward axis, and above the horizon
  bool is_y_up = false;                 ///< else z
  uint32_t width = 1200, height = 900;  ///< pixels
};

/// A perspective view. Its coordinates are right, up and forward, from the middle of what it shows, whose size is about
/// 1: single precision suffices, wherever the scene is.
class View {
 public:
  /// The eye and, straight before it, the middle of what it shows, along the axes of View::axes(); the size of that.
  View(const ViewOptions& options, const scenes::Vec3d& eye, double middle_depth, double size);

  /// Right, up and forward for these options.
  static std::array<scenes::Vec3d, 3> axes(const ViewOptions& options);
  /// Half of the picture's width and height at distance 1 from the eye.
  static std::array<double, 2> tangents(const ViewOptions& options);

  scenes::Vec3d from_scene(const scenes::Vec3d& position) const;
  scenes::Vec3d direction_from_scene(const scenes::Vec3d& direction) const;
  scenes::Vec3d eye() const { return {0, 0, -distance_}; }
  /// The unit direction from the eye through a point of the picture, in pixels from its upper left corner.
  scenes::Vec3d direction(double column, double row) const;
  /// How wide a pixel is at a distance from the eye.
  double pixel(double distance) const { return distance * pixel_; }
  /// How wide it is in the middle of what is seen.
  double middle_pixel() const { return pixel(distance_); }
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }

 private:
  std::array<scenes::Vec3d, 3> axes_;
  uint32_t width_, height_;
  scenes::Vec3d middle_;  ///< along the axes
  double scale_, distance_, pixel_;
};

/// Finds the nearest view that shows a set of positions whole.
class Framing {
 public:
  explicit Framing(const ViewOptions& options)
      : options_(options), axes_(View::axes(options)), tangents_(View::tangents(options)) {}
  void add(const scenes::Vec3d& position);
  bool is_empty() const { return lower_[0] > upper_[0]; }
  /// Of the box around all positions.
  double size() const { return scenes::length(scenes::minus(upper_, lower_)); }
  /// With so much room to all sides. Throws std::runtime_error for a scene that is too large.
  View view(double margin = 0) const;

 private:
  static constexpr double kFar = std::numeric_limits<double>::infinity();
  ViewOptions options_;
  std::array<scenes::Vec3d, 3> axes_;
  std::array<double, 2> tangents_;
  scenes::Vec3d lower_{kFar, kFar, kFar}, upper_{-kFar, -kFar, -kFar};  ///< along the axes
  // Where planes through all of what is seen, one for each side of the picture, cut the forward axis.
  std::array<std::array<double, 2>, 2> sides_{{{-kFar, -kFar}, {-kFar, -kFar}}};
};

}  // namespace collided::cli
