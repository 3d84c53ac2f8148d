#include "gpu/exact/features.hpp"

#include <initializer_list>
#include <utility>

namespace collided::exact {
namespace {

using Vector = Vec3<Form>;

/// Vectors p and q from the ends of a segment to a point, or both from the point to the ends, and n = p x q or -p x q.
struct Side {
  const Vector &p, &q, &n;
};

/// distance <= h as a form that is not negative, given distance * |d| (its square) and d.
Form within(const Form& squared, const Form& thickness, const Vector& d) {
  return thickness * thickness * dot(d, d) - squared;
}

Case point_near_point(const Vector& d, const Form& thickness) { return {{}, {thickness * thickness - dot(d, d)}, {}}; }

// p and q are parallel and do not lead to the same side. True of segments without length, too.
Case point_on_segment(const Side& side) { return {{side.n.x, side.n.y, side.n.z}, {-dot(side.p, side.q)}, {}}; }

// The point's foot is on the segment e = p - q, which has a length; |n| = distance * |e|.
Case point_near_segment(const Side& side, const Form& thickness) {
  const Vector e = side.p - side.q;
  return {{}, {dot(side.p, e), -dot(side.q, e), within(dot(side.n, side.n), thickness, e)}, {dot(e, e)}};
}

// The weights of the closest points, times n^2, are not negative, and |volume| = distance * |n|. Without thickness
// the volume has to be 0, which is necessary in any case.
Case planes_near(std::vector<Form> weights, const Form& volume, const Vector& n, const Form& thickness) {
  if (thickness.vanishes()) return {{}, std::move(weights), {dot(n, n)}};
  weights.push_back(within(volume * volume, thickness, n));
  return {{}, std::move(weights), {dot(n, n)}};
}

// The points at the sides and, with a thickness, at their ends. Without one, a point at an end is on the side, too.
void add_outline(Contact& contact, std::initializer_list<Side> sides, std::initializer_list<const Vector*> to_ends,
                 const Form& thickness) {
  if (thickness.vanishes()) {
    for (const Side& side : sides) contact.add(point_on_segment(side));
    return;
  }
  for (const Side& side : sides) contact.add(point_near_segment(side, thickness));
  for (const Vector* d : to_ends) contact.add(point_near_point(*d, thickness));
}

// With A, B, C from the corners to the vertex, n = (b - a) x (c - a) = B x C + C x A + A x B. The weights of the vertex
// in the triangle are (B x C) n, (C x A) n and (A x B) n over n^2, and A (B x C) is its height times |n|. Where no
// weight is negative, the distance is the height, else that to a side; a triangle without area is its sides.
Contact vertex_triangle_contact(const ExactQuery& query) {
  const auto& [v, a, b, c] = query.points;
  const Form& thickness = query.thickness;
  const Vector A = v - a, B = v - b, C = v - c;
  const Vector bc = cross(B, C);
  const Form volume = dot(A, bc);
  Contact contact{thickness.vanishes() ? volume : Form(), {}};
  if (closed_sign(contact.necessary) != 0) return contact;
  const Vector ca = cross(C, A), ab = cross(A, B), n = bc + ca + ab;
  contact.add(planes_near({dot(bc, n), dot(ca, n), dot(ab, n)}, volume, n, thickness));
  add_outline(contact, {{B, C, bc}, {C, A, ca}, {A, B, ab}}, {&A, &B, &C}, thickness);
  return contact;
}

// With A = a0 - b0, B = a0 - b1, C = a1 - b0, D = a1 - b1, n = (a1 - a0) x (b1 - b0) = (C - A) x (A - B). The closest
// points of the two lines have the weights (A x B) n of a1, (D x C) n of a0, (C x A) n of b1 and (B x D) n of b0, over
// n^2, and A (B x C) is the lines' distance times |n|. Where a weight is negative or the edges are parallel, an end
// of one edge is among the closest points.
Contact edge_edge_contact(const ExactQuery& query) {
  const auto& [a0, a1, b0, b1] = query.points;
  const Form& thickness = query.thickness;
  const Vector A = a0 - b0, B = a0 - b1, C = a1 - b0, D = a1 - b1;
  const Vector ab = cross(A, B);
  const Form volume = dot(C, ab);
  Contact contact{thickness.vanishes() ? volume : Form(), {}};
  if (closed_sign(contact.necessary) != 0) return contact;
  const Vector dc = cross(D, C), ca = cross(C, A), bd = cross(B, D), n = cross(C - A, A - B);
  contact.add(planes_near({dot(ab, n), dot(dc, n), dot(ca, n), dot(bd, n)}, volume, n, thickness));
  add_outline(contact, {{A, B, ab}, {D, C, dc}, {C, A, ca}, {B, D, bd}}, {&A, &B, &C, &D}, thickness);
  return contact;
}

}  // namespace

Contact contact_of(ContactKind kind, const ExactQuery& query) {
  return kind == ContactKind::kVertexTriangle ? vertex_triangle_contact(query) : edge_edge_contact(query);
}

}  // namespace collided::exact
