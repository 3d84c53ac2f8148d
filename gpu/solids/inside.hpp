#pragma once
// Which vertices are in which solids, by winding numbers.

#include "gpu/base/keys.hpp"
#include "gpu/base/mesh_filter.hpp"
#include "gpu/exact/fixed/ray_triangle.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/solids/rays.hpp"
#include "gpu/solids/tree.hpp"

namespace collided {

/// Numbers of a search; on the backend.
struct SolidCounts {
  uint64_t inside = 0;      ///< pairs of a vertex and a solid that it is in
  uint64_t doubtful = 0;    ///< pairs that double precision leaves open
  uint64_t open = 0;        ///< those of them that the host has to decide
  uint64_t on = 0;          ///< those of them in which the vertex is on the solid
  uint64_t inside_out = 0;  ///< pairs whose winding number is below 0
  uint64_t rivals = 0;      ///< triangles that may be as near as the nearest ones (solids/nearest.hpp)
};

/// Where pairs of a vertex and a solid (pack_ids) go.
struct SolidLists {
  AppendList<uint64_t> inside, doubtful, open, on;
  uint64_t* inside_out;

  COLLIDED_HD void tell(uint32_t vertex, uint32_t solid, int winding) const {
    if (winding > 0) inside.push(pack_ids(vertex, solid));
    if (winding < 0) atomic_add(*inside_out, uint64_t{1});
  }
};

/// Winding numbers of the solids with the lowest numbers from a certain one on, as many as there is room for.
class Windings {
 public:
  static constexpr uint32_t kNone = ~0u;
  static constexpr int kRoom = 4;

  COLLIDED_HD explicit Windings(uint32_t first) : first_(first) {}

  COLLIDED_HD void add(uint32_t solid, RaySign sign) {
    if (solid < first_ || sign == RaySign::kPasses) return;
    const int at = place_of(solid);
    if (at == kRoom) return;
    if (sign == RaySign::kDoubt) is_doubtful_[at] = true;
    winding_[at] += sign == RaySign::kLeaves ? 1 : sign == RaySign::kEnters ? -1 : 0;
  }
  /// use(solid, winding number, whether it is in doubt), from the lowest solid on.
  template <class Use>
  COLLIDED_HD void for_each(const Use& use) const {
    for (int i = 0; i < count_; ++i) use(solid_[i], winding_[i], is_doubtful_[i]);
  }
  /// Returns the solid to go on with; kNone if all had room.
  COLLIDED_HD uint32_t next() const { return next_; }

 private:
  /// Returns kRoom where there is none.
  COLLIDED_HD int place_of(uint32_t solid) {
    int at = 0;
    while (at < count_ && solid_[at] < solid) ++at;
    if (at < count_ && solid_[at] == solid) return at;
    if (at == kRoom) {
      next_ = min(next_, solid);
      return kRoom;
    }
    if (count_ == kRoom) next_ = min(next_, solid_[--count_]);
    for (int i = count_++; i > at; --i)
      solid_[i] = solid_[i - 1], winding_[i] = winding_[i - 1], is_doubtful_[i] = is_doubtful_[i - 1];
    solid_[at] = solid, winding_[at] = 0, is_doubtful_[at] = false;
    return at;
  }

  uint32_t first_, next_ = kNone;
  int count_ = 0;
  uint32_t solid_[kRoom];
  int winding_[kRoom];
  bool is_doubtful_[kRoom];
};

/// Looks up from each vertex.
template <class Real>
struct FindInside {
  SolidTree<Real> tree;
  Span<const MeshVertex> vertices;
  PairFilter filter;
  SolidLists lists;

  COLLIDED_HD void operator()(uint64_t i) const {
    const MeshVertex v = vertices[i];
    const Vec3<double> from = tree.point(v.vertex);
    for (uint32_t first = 0; first != Windings::kNone;) {
      Windings windings(first);
      tree.walk_others(
          v.solid, [&](const Box<float>& box) { return may_meet(from, box); },
          [&](uint32_t place) {
            const SolidTriangle triangle = tree.triangles[place];
            if (triangle.solid < first || triangle.mesh == v.mesh) return;
            if (!filter.may_touch_meshes(v.mesh, triangle.mesh)) return;
            Vec3<double> corners[3];
            tree.corners_of(place, corners);
            windings.add(triangle.solid, look_along_ray(from, corners));
          });
      windings.for_each([&](uint32_t solid, int winding, bool is_doubtful) {
        if (is_doubtful) lists.doubtful.push(pack_ids(v.vertex, solid));
        if (!is_doubtful) lists.tell(v.vertex, solid, winding);
      });
      first = windings.next();
    }
  }
};

/// Decides what double precision leaves open.
template <class Real>
struct DecideInside {
  SolidTree<Real> tree;
  Span<const uint64_t> doubtful;
  SolidLists lists;

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint32_t vertex = first_id(doubtful[i]), solid = second_id(doubtful[i]);
    const Vec3<double> from = tree.point(vertex);
    int winding = 0;
    bool is_on = false, is_open = false;
    tree.walk_one(
        solid, [&](const Box<float>& box) { return !is_on && !is_open && may_meet(from, box); },
        [&](uint32_t place) {
          const RayVerdict verdict = verdict_of(vertex, tree.triangles[place], is_open);
          winding += verdict.crossing;
          is_on = is_on || verdict.is_on;
        });
    if (is_on) return (void)lists.on.push(doubtful[i]);
    if (is_open) return (void)lists.open.push(doubtful[i]);
    lists.tell(vertex, solid, winding);
  }

 private:
  COLLIDED_HD RayVerdict verdict_of(uint32_t vertex, const SolidTriangle& triangle, bool& is_open) const {
    const Vec3<uint32_t> t = triangle.corners;
    const Vec3<double> points[4] = {tree.point(vertex), tree.point(t.x), tree.point(t.y), tree.point(t.z)};
    const RaySign sign = look_along_ray(points[0], {points[1], points[2], points[3]});
    if (sign != RaySign::kDoubt) return {sign == RaySign::kLeaves ? 1 : sign == RaySign::kEnters ? -1 : 0, false};
    RayVerdict verdict;
    if (!exact::fixed::decide_ray(points, {vertex, t.x, t.y, t.z}, verdict)) is_open = true;
    return verdict;
  }
};

}  // namespace collided
