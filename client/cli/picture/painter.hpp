#pragma once
// Paints meshes and marks, as they are seen from somewhere.

#include <vector>

#include "client/cli/picture/marks.hpp"
#include "client/cli/picture/png.hpp"
#include "client/cli/picture/ray_scene.hpp"
#include "client/cli/picture/view.hpp"

namespace collided::cli {

/// A colour, linear, of red, green and blue; 1 is white.
using Colour = scenes::Vec3d;

/// Light grey surfaces with shadows; contacts of vertices are vermilion balls, those of edges blue crosses, and
/// crossings purple lines. Marks behind a surface shine through it. The same input gives the same image.
class Painter {
 public:
  Painter(const View& view, const client::SceneFeatures& scene, client::Positions positions, const Marks& marks);

  /// Uses all cores. Returns early if collidectl is interrupted.
  Image paint() const;

 private:
  /// One of several in a pixel.
  struct Sample {
    uint64_t pixel, number;
  };

  Colour colour_of_mesh(uint32_t element) const;
  void add_surfaces();
  void tint(const std::vector<uint32_t>& elements, const Colour& colour);
  void add_marks(const Marks& marks);
  Colour pixel(uint32_t column, uint32_t row) const;
  Colour seen(const scenes::Vec3d& direction, const Sample& sample) const;
  Colour lit(const RayHit& hit, const scenes::Vec3d& direction, const Sample& sample) const;
  double openness(const scenes::Vec3d& point, const scenes::Vec3d& normal, const Sample& sample) const;
  double outline(uint32_t element, const RayHit& hit) const;

  View view_;
  const client::SceneFeatures& scene_;
  std::vector<scenes::Vec3d> positions_;  ///< in the view
  RayScene surfaces_, marks_;
  std::vector<std::vector<uint32_t>> drawn_;  ///< elements by part of surfaces_
  std::vector<Colour> colours_;               ///< of elements
};

}  // namespace collided::cli
