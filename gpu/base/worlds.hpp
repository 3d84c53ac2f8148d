#pragma once
// A scene of several worlds: copies of the same meshes, each with positions of its own, that never touch each other.
// What is made of the meshes is stored once. World w has the ids of the first world, moved by w times their number, so
// that a pair of ids tells its world, and contacts in order are those of one world after the other.

#include "gpu/base/vec3.hpp"

namespace collided {

/// What one world has; of a scene that is no set of worlds: all that there is.
struct WorldShape {
  uint32_t worlds = 1;
  uint32_t vertices = 0, edges = 0, triangles = 0;

  COLLIDED_HD bool is_one() const { return worlds == 1; }
};

/// What a frame does with a world; a byte each.
constexpr uint8_t kStepsWorld = 1;      ///< it has positions of it, which count
constexpr uint8_t kIsFirstOfWorld = 2;  ///< its first ones

/// Which triangles a step is of. Of a scene that is one: all.
struct SteppedWorlds {
  const uint8_t* frame = nullptr;  ///< of each world
  uint32_t triangles = 0;          ///< of a world

  COLLIDED_HD bool has(uint64_t triangle) const {
    return frame == nullptr || (frame[static_cast<uint32_t>(triangle) / triangles] & kStepsWorld) != 0;
  }
};

COLLIDED_HD inline Vec3<uint32_t> with_ids_moved(const Vec3<uint32_t>& ids, uint32_t by) {
  return {ids.x + by, ids.y + by, ids.z + by};
}

/// Ids of features by those of others, stored for one world, read for any.
template <class T>
class WorldTable {
 public:
  WorldTable() = default;
  /// Of a scene that is one.
  template <class U, class = std::enable_if_t<std::is_same_v<const U, const T>>>
  COLLIDED_HD WorldTable(const Span<U>& of_all) : of_one_(of_all), count_(of_all.size()) {}
  /// `ids`: how many of those that it holds a world has.
  COLLIDED_HD WorldTable(const Span<const T>& of_one, uint32_t worlds, uint32_t ids)
      : of_one_(of_one), count_(of_one.size() * worlds), ids_(ids) {}

  COLLIDED_HD uint64_t size() const { return count_; }
  COLLIDED_HD bool empty() const { return count_ == 0; }
  COLLIDED_HD T operator[](uint64_t i) const {
    if (count_ == of_one_.size()) return of_one_[i];
    const uint32_t of_world = static_cast<uint32_t>(of_one_.size()), id = static_cast<uint32_t>(i);
    const uint32_t world = id / of_world;
    return with_ids_moved(of_one_[id - world * of_world], world * ids_);
  }

 private:
  Span<const T> of_one_ = {};
  uint64_t count_ = 0;
  uint32_t ids_ = 0;
};

}  // namespace collided
