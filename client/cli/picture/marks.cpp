// Marks of a picture: contacts of vertices with triangles, contacts of edges, and lines along which triangles cross.

#include "client/cli/picture/marks.hpp"

#include <algorithm>

#include "client/app/output/located.hpp"

namespace collided::cli {

namespace {

using scenes::Vec3d;
using Corners = std::array<Vec3d, 3>;

/// Where the edges of one triangle meet the plane of the other one, as far as they do.
void add_edge_meetings(const Corners& of, const Corners& plane, std::vector<Vec3d>& out) {
  const Vec3d normal = scenes::cross(scenes::minus(plane[1], plane[0]), scenes::minus(plane[2], plane[0]));
  for (size_t i = 0; i < 3; ++i) {
    const Vec3d &a = of[i], &b = of[(i + 1) % 3];
    const double above = scenes::dot(normal, scenes::minus(a, plane[0]));
    const double below = scenes::dot(normal, scenes::minus(b, plane[0]));
    if (above == below || (above > 0) == (below > 0)) continue;
    out.push_back(scenes::between(a, b, above / (above - below)));
  }
}

}  // namespace

std::array<Vec3d, 2> crossing_of(const Corners& a, const Corners& b) {
  std::vector<Vec3d> of_a, of_b;
  add_edge_meetings(a, b, of_a);
  add_edge_meetings(b, a, of_b);
  if (of_a.size() < 2 || of_b.size() < 2) {  // they only touch, or lie in one plane
    const Vec3d& near = of_a.empty() ? of_b.empty() ? a[0] : of_b[0] : of_a[0];
    return {near, near};
  }
  // Both pairs lie on the line in which the planes meet; what the triangles share is between its two middle points.
  const Vec3d along = scenes::minus(of_a[1], of_a[0]);
  std::vector<Vec3d> line{of_a[0], of_a[1], of_b[0], of_b[1]};
  std::sort(line.begin(), line.end(),
            [&](const Vec3d& p, const Vec3d& q) { return scenes::dot(along, p) < scenes::dot(along, q); });
  return {line[1], line[2]};
}

void mark_contacts(Marks& marks, const client::FrameOutput& output, const StepPositions& positions) {
  for_each_located(output, positions, [&](const LocatedContact& contact) {
    const Vec3d middle = scenes::between(contact.points.first, contact.points.second, 0.5);
    if (contact.kind == v1::CONTACT_KIND_VERTEX_TRIANGLE || contact.kind == v1::CONTACT_KIND_VERTEX_SOLID) {
      marks.vertices.push_back(middle);
      if (!contact.contacts.elements.empty()) marks.touched.push_back(contact.contacts.elements[contact.i][1]);
      return;
    }
    if (contact.kind != v1::CONTACT_KIND_EDGE_EDGE) return;  // contours show the others
    const auto& stencil = contact.contacts.stencils[contact.i];
    const auto edge = [&](size_t from) {
      return scenes::minus(positions.end[stencil[from + 1]], positions.end[stencil[from]]);
    };
    marks.edges.push_back({middle, edge(0), edge(2)});
  });
}

void mark_triangle_pairs(Marks& marks, const client::Contacts& pairs, const client::SceneFeatures& scene,
                         client::Positions positions) {
  const auto corners = [&](uint32_t id) {
    const auto& [a, b, c] = scene.element(id);
    return Corners{positions[a], positions[b], positions[c]};
  };
  for (const auto& [a, b] : pairs.elements) {
    marks.crossings.push_back(crossing_of(corners(a), corners(b)));
    marks.crossed.insert(marks.crossed.end(), {a, b});
  }
}

void mark_contours(Marks& marks, const client::Contacts& crossings, const client::SceneFeatures& scene,
                   client::Positions positions) {
  for (const client::Contour& contour : client::join_crossings(crossings, scene, positions)) {
    const auto& points = contour.points;
    for (size_t i = 1; i < points.size(); ++i) marks.crossings.push_back({points[i - 1].position, points[i].position});
    if (contour.is_closed || points.size() == 1)
      marks.crossings.push_back({points.back().position, points.front().position});
  }
  for (const auto& [edge, triangle] : crossings.elements) {
    marks.crossed.push_back(triangle);
    const auto own = scene.triangles_of(edge);
    marks.crossed.insert(marks.crossed.end(), own.begin(), own.end());
  }
}

}  // namespace collided::cli
