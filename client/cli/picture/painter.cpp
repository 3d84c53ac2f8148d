// Paints meshes and marks, as they are seen from somewhere.

#include "client/cli/picture/painter.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "client/app/daemon/interrupt.hpp"
#include "client/scenes/math.hpp"

namespace collided::cli {

namespace {

using scenes::Vec3d;

constexpr int kSide = 3;        // samples of a pixel, squared
constexpr int kSkyRays = 2;     // of each sample, to where light may come from
constexpr double kReach = 0.5;  // how far surfaces darken each other; what is seen has a size of about 2
constexpr double kLift = 1e-4;  // that rays begin above a surface
constexpr double kShine = 0.3;  // how much of a mark is seen through a surface

// From what people see (sRGB) to amounts of light, and back.
double to_linear(double x) { return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }
double to_srgb(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; }
Colour colour(double red, double green, double blue) { return {to_linear(red), to_linear(green), to_linear(blue)}; }

enum SurfacePart : uint32_t { kTriangles, kLooseEdges, kLoosePoints, kSurfaceParts };

const Colour kPaper = colour(0.97, 0.97, 0.98), kInk = colour(0.16, 0.18, 0.22);
// Light, so that marks stand out.
const Colour kMeshes[] = {colour(0.76, 0.80, 0.86), colour(0.88, 0.83, 0.73), colour(0.77, 0.85, 0.76),
                          colour(0.86, 0.79, 0.84), colour(0.74, 0.86, 0.86), colour(0.84, 0.84, 0.84)};
// Of Okabe and Ito's palette, which people of every colour vision can tell apart.
const Colour kVertex = colour(0.84, 0.37, 0.0), kEdge = colour(0.0, 0.45, 0.70), kCrossing = colour(0.72, 0.16, 0.55);

const Colour kMarks[] = {kVertex, kEdge, kCrossing};  // by part

Colour mix(const Colour& a, const Colour& b, double part_of_b) { return scenes::between(a, b, part_of_b); }

/// Two directions across a unit vector.
std::pair<Vec3d, Vec3d> across(const Vec3d& normal) {
  const Vec3d other = std::abs(normal[0]) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d first = scenes::unit(scenes::cross(normal, other));
  return {first, scenes::cross(normal, first)};
}

/// A direction around a normal, those near it more often, by two numbers in [0, 1).
Vec3d around(const Vec3d& normal, double a, double b) {
  const auto [x, y] = across(normal);
  const double r = std::sqrt(a), angle = 2 * scenes::kPi * b;
  return scenes::unit(
      scenes::plus(scenes::times(normal, std::sqrt(1 - a)),
                   scenes::plus(scenes::times(x, r * std::cos(angle)), scenes::times(y, r * std::sin(angle)))));
}

/// Number `i` of a series for each `seed`, whose first ones are spread as evenly as their number allows: in the square
/// [0, 1) x [0, 1) (Roberts' R2 series).
std::array<double, 2> spread(uint64_t seed, uint64_t i) {
  const auto n = static_cast<double>(i);
  const double a = scenes::hash01(seed, 1) + 0.7548776662466927 * n,
               b = scenes::hash01(seed, 2) + 0.5698402909980532 * n;
  return {a - std::floor(a), b - std::floor(b)};
}

/// Smaller, the more there are.
double mark_pixels(const Marks& marks) {
  const auto count = static_cast<double>(marks.vertices.size() + marks.edges.size() + marks.crossings.size());
  return std::clamp(9 * std::pow(50 / std::max(count, 1.0), 0.25), 2.2, 9.0);
}

}  // namespace

Painter::Painter(const View& view, const client::SceneFeatures& scene, client::Positions positions, const Marks& marks)
    : view_(view), scene_(scene) {
  for (const Vec3d& position : positions) positions_.push_back(view.from_scene(position));
  for (uint32_t id = 0; id < scene.element_count(); ++id) colours_.push_back(colour_of_mesh(id));
  tint(marks.touched, kVertex);
  tint(marks.crossed, kCrossing);
  add_surfaces();
  add_marks(marks);
}

Colour Painter::colour_of_mesh(uint32_t element) const {
  return kMeshes[scene_.mesh_of_element(element) % std::size(kMeshes)];
}

void Painter::tint(const std::vector<uint32_t>& elements, const Colour& colour) {
  for (const uint32_t id : elements) {
    colours_[client::checked_id("element", id, colours_.size())] = mix(colour_of_mesh(id), colour, 0.4);
  }
}

void Painter::add_surfaces() {
  constexpr double kLoosePixels = 1.5;
  const double radius = kLoosePixels * view_.middle_pixel();
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<Tube> edges;
  std::vector<Vec3d> points;
  drawn_.resize(kSurfaceParts);
  for (uint32_t id = 0; id < scene_.element_count(); ++id) {
    const auto& [a, b, c] = scene_.element(id);
    if (b != c) {
      triangles.push_back({a, b, c});
    } else if (a != b) {
      edges.push_back({positions_[a], positions_[b]});
    } else {
      points.push_back(positions_[a]);
    }
    drawn_[b != c ? kTriangles : a != b ? kLooseEdges : kLoosePoints].push_back(id);
  }
  surfaces_.add_triangles(kTriangles, positions_, triangles);
  surfaces_.add_tubes(kLooseEdges, edges, radius);
  surfaces_.add_balls(kLoosePoints, points, 2 * radius);
  surfaces_.commit();
}

void Painter::add_marks(const Marks& marks) {
  const double radius = mark_pixels(marks) * view_.middle_pixel();
  std::vector<Vec3d> balls;
  std::vector<Tube> crosses, lines;
  const auto add_tube = [&](std::vector<Tube>& tubes, const Vec3d& middle, const Vec3d& way, double half_length) {
    const Vec3d half = scenes::times(scenes::length(way) > 0 ? scenes::unit(way) : Vec3d{1, 0, 0}, half_length);
    tubes.push_back({scenes::minus(middle, half), scenes::plus(middle, half)});
  };
  for (const Vec3d& point : marks.vertices) balls.push_back(view_.from_scene(point));
  for (const EdgeMark& edge : marks.edges)
    for (const Vec3d& way : {edge.first, edge.second})
      add_tube(crosses, view_.from_scene(edge.point), view_.direction_from_scene(way), 1.7 * radius);
  for (const auto& [a, b] : marks.crossings) {
    const Vec3d from = view_.from_scene(a), to = view_.from_scene(b), way = scenes::minus(to, from);
    add_tube(lines, scenes::between(from, to, 0.5), way, std::max(0.5 * scenes::length(way), 0.2 * radius));
  }
  marks_.add_balls(0, balls, radius);
  marks_.add_tubes(1, crosses, 0.5 * radius);
  marks_.add_tubes(2, lines, 0.4 * radius);
  marks_.commit();
}

Image Painter::paint() const {
  Image image{view_.width(), view_.height()};
  image.pixels.resize(size_t{3} * image.width * image.height);
  tbb::parallel_for(uint32_t{0}, image.height, [&](uint32_t row) {
    if (is_interrupted()) return;
    uint8_t* out = image.pixels.data() + size_t{3} * image.width * row;
    for (uint32_t column = 0; column < image.width; ++column)
      for (const double light : pixel(column, row))
        *out++ = static_cast<uint8_t>(std::lround(255 * to_srgb(std::clamp(light, 0.0, 1.0))));
  });
  return image;
}

Colour Painter::pixel(uint32_t column, uint32_t row) const {
  constexpr int kSamples = kSide * kSide;
  const uint64_t number = uint64_t{row} * view_.width() + column;
  Colour sum{};
  for (int i = 0; i < kSamples; ++i) {
    const double x = column + (i % kSide + 0.5) / kSide, y = row + (i / kSide + 0.5) / kSide;
    sum = scenes::plus(sum, seen(view_.direction(x, y), {number, static_cast<uint64_t>(i)}));
  }
  return scenes::times(sum, 1.0 / kSamples);
}

/// What comes to the eye from a direction.
Colour Painter::seen(const Vec3d& direction, const Sample& sample) const {
  const auto surface = surfaces_.first_hit(view_.eye(), direction);
  const auto mark = marks_.first_hit(view_.eye(), direction);
  const Colour behind = surface ? lit(*surface, direction, sample) : kPaper;
  if (!mark) return behind;
  const double facing = -scenes::dot(mark->normal, direction);
  const Colour own = scenes::times(kMarks[mark->part], 0.45 + 0.55 * facing);
  return mix(behind, own, !surface || mark->distance < surface->distance ? 1 : kShine);
}

Colour Painter::lit(const RayHit& hit, const Vec3d& direction, const Sample& sample) const {
  const uint32_t element = drawn_[hit.part][hit.primitive];
  const Vec3d point =
      scenes::plus(scenes::plus(view_.eye(), scenes::times(direction, hit.distance)), scenes::times(hit.normal, kLift));
  // From over the viewer's left shoulder, as on maps; not from one point, so that shadows are soft.
  const auto [right, back] = spread(sample.pixel, sample.number);
  const Vec3d light = scenes::unit({-0.6 + 0.1 * right, 0.85, -0.95 + 0.1 * back});
  const double towards = std::max(0.0, scenes::dot(hit.normal, light));
  const bool is_lit = towards > 0 && !surfaces_.is_blocked(point, light, 10);
  const double facing = -scenes::dot(hit.normal, direction);
  const double bright = (0.42 + 0.14 * facing) * openness(point, hit.normal, sample) + (is_lit ? 0.52 * towards : 0);
  const Colour own = hit.part == kTriangles ? mix(colours_[element], kInk, outline(element, hit)) : colours_[element];
  return scenes::times(own, bright);
}

/// How much of the sky lights a point: 1, or less where other surfaces are near.
double Painter::openness(const Vec3d& point, const Vec3d& normal, const Sample& sample) const {
  int open = 0;
  for (uint64_t i = 0; i < kSkyRays; ++i) {
    const auto [a, b] = spread(~sample.pixel, kSkyRays * sample.number + i);
    const Vec3d way = around(normal, a, b);
    open += surfaces_.is_blocked(point, way, kReach) ? 0 : 1;
  }
  return open / double{kSkyRays};
}

/// How much of a triangle's border is seen at a point of it; nothing of triangles that are small in the picture.
double Painter::outline(uint32_t element, const RayHit& hit) const {
  constexpr double kDarkest = 0.4, kWidth = 0.7;
  const auto& [a, b, c] = scene_.element(element);
  const Vec3d corners[] = {positions_[a], positions_[b], positions_[c]};
  const double area =
      scenes::length(scenes::cross(scenes::minus(corners[1], corners[0]), scenes::minus(corners[2], corners[0])));
  const double weights[] = {1 - hit.u - hit.v, hit.u, hit.v}, pixel = view_.pixel(hit.distance);
  double nearest = 1e9, smallest = 1e9;  // in pixels
  for (size_t i = 0; i < 3; ++i) {
    const double side = scenes::length(scenes::minus(corners[(i + 2) % 3], corners[(i + 1) % 3]));
    const double altitude = area / side / pixel;
    smallest = std::min(smallest, altitude);
    nearest = std::min(nearest, weights[i] * altitude);
  }
  return kDarkest * scenes::smooth(4, 14, smallest) * (1 - scenes::smooth(0.5 * kWidth, 1.5 * kWidth, nearest));
}

}  // namespace collided::cli
