#pragma once
// Four queries side by side.

#include "gpu/base/four.hpp"
#include "gpu/narrow/certified_ccd.hpp"

namespace collided {

template <class Kind>
using FourDifferences = DifferencesOf<Four<float>, Kind>;

template <class Real>
void set_lane(Vec3<Four<Real>>& to, int lane, const Vec3<Real>& from) {
  to.x.set(lane, from.x), to.y.set(lane, from.y), to.z.set(lane, from.z);
}

/// Four queries in float; those after the last one are copies of it.
template <class Kind>
struct FourQueries {
  uint64_t keys[4];
  uint32_t loaded;  ///< bit k: what CcdQueries::load returns
  FourDifferences<Kind> d;
  Four<float> thickness;

  template <class Real>
  void load(const CcdQueries<Real, Kind, uint64_t>& queries, uint64_t first, uint64_t end) {
    FeaturePoints<Four<Real>> points;
    for (int lane = 0; lane < 4; ++lane) {
      keys[lane] = queries.key(min(first + static_cast<uint64_t>(lane), end - 1));
      const Stencil stencil = queries.kind.stencil(keys[lane]);
      for (int k = 0; k < 4; ++k) {
        set_lane(points.start[k], lane, queries.start[stencil.v[k]]);
        set_lane(points.end[k], lane, queries.end[stencil.v[k]]);
      }
    }
    loaded = load_differences<Kind, Four<float>>(points, d).bits();
    thickness = widened_thickness(queries);
  }

 private:
  template <class Real>
  Four<float> widened_thickness(const CcdQueries<Real, Kind, uint64_t>& queries) const {
    if (queries.has_one_distance()) return scaled_thickness<float>(queries.doubtful_distance_of(keys[0]), d.scale);
    Four<float> out;
    for (int lane = 0; lane < 4; ++lane)
      out.set(lane, scaled_thickness<float>(queries.doubtful_distance_of(keys[lane]), d.scale[lane]));
    return out;
  }
};

}  // namespace collided
