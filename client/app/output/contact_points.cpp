// Where contacts are: the closest points of their two features, at the time of the contact.

#include "client/app/output/contact_points.hpp"

#include <algorithm>

#include "client/scenes/vec3.hpp"
#include "collided/v1/scene.pb.h"

namespace collided::cli {

namespace {

using scenes::between;
using Point = scenes::Vec3d;

Point in_triangle(const std::array<Point, 4>& x, const std::array<double, 2>& w) {
  Point out;
  for (size_t axis = 0; axis < 3; ++axis)
    out[axis] = (1 - w[0] - w[1]) * x[1][axis] + w[0] * x[2][axis] + w[1] * x[3][axis];
  return out;
}

}  // namespace

std::optional<ContactPoints> contact_points(v1::ContactKind kind, const client::Contacts& contacts, size_t i,
                                            const StepPositions& positions) {
  if (contacts.weights.empty()) return {};
  if (kind == v1::CONTACT_KIND_EDGE_TRIANGLE) {
    if (positions.scene == nullptr || contacts.elements.empty()) return {};
    const Point point = client::crossing_point(contacts, i, *positions.scene, positions.end);
    return ContactPoints{point, point};
  }
  if (contacts.stencils.empty()) return {};
  const bool moves = !positions.start.empty() && !contacts.toi.empty();
  std::array<Point, 4> x;
  for (size_t k = 0; k < x.size(); ++k) {
    const uint32_t vertex = client::checked_id("vertex", contacts.stencils[i][k], positions.end.size());
    x[k] = moves ? between(positions.start[vertex], positions.end[vertex], contacts.toi[i]) : positions.end[vertex];
  }
  const auto& w = contacts.weights[i];
  if (kind != v1::CONTACT_KIND_EDGE_EDGE) return ContactPoints{x[0], in_triangle(x, w)};
  return ContactPoints{between(x[0], x[1], w[0]), between(x[2], x[3], w[1])};
}

bool asks_for(const v1::SceneSpec& spec, v1::ContactKind kind) {
  return std::ranges::count(spec.kinds(), int{kind}) > 0;
}

bool asks_for_crossings(const v1::SceneSpec& spec) { return asks_for(spec, v1::CONTACT_KIND_EDGE_TRIANGLE); }

}  // namespace collided::cli
