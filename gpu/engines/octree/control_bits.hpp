#pragma once
// Control bits: on which axes a member of a leaf starts in the leaf's cell. Two members that share cells are tested in
// the one cell where, on each axis, one of them starts (the cell of the larger of their lower corners); in an order by
// these bits, a member meets no more than a run of those after it.

#include "gpu/base/host_device.hpp"

namespace collided {

/// The members of a leaf in the order of their control bits: those that start in the cell on all axes first, then those
/// that do on two, on one, and on none. A place and the one as far from the end hold bits that are each other's
/// complement.
struct MembersByStart {
  static constexpr uint32_t kPlaces = 8;
  uint32_t end[kPlaces];  ///< behind the last member of each place

  /// `axes`: bit k for axis k.
  COLLIDED_HD static constexpr uint32_t place_of(uint32_t axes) { return 0x01243567u >> (4 * axes) & 7u; }

  /// Behind the last member that this one, or any after it, is to be tested with; those are all after it.
  COLLIDED_HD uint32_t end_for(uint32_t member) const {
    for (uint32_t place = 0; place < kPlaces / 2; ++place)
      if (member < end[place]) return end[kPlaces - 1 - place];
    return 0;
  }

  /// Pairs whose bits let them be tested in this cell.
  COLLIDED_HD uint64_t tests() const {
    const uint64_t all = end[kPlaces - 1], home = end[0];
    const uint64_t yz = members(6), xz = members(5), xy = members(3);
    return home * (home - 1) / 2 + home * (all - home) + yz * (xz + xy + members(1)) + xz * (xy + members(2)) +
           xy * members(4);
  }

 private:
  COLLIDED_HD uint64_t members(uint32_t axes) const {
    const uint32_t place = place_of(axes);
    return end[place] - (place == 0 ? 0 : end[place - 1]);
  }
};

}  // namespace collided
