#pragma once
// How long a scene's lists get. A step finds out how much room they need; where they have too little, they are enlarged
// and a part of the step runs again. A scene that knows beforehand is spared that.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>

namespace collided {

/// Of a list that a scene may expect.
constexpr uint64_t kMaxListLength = ~uint32_t{0};

/// Lengths of those lists whose need does not follow from the number of triangles. 0: not known.
struct ListLengths {
  enum List : size_t {
    kBricks,  ///< from here on: of the octree
    kBrickItems,
    kLarge,
    kLeaves,
    kRegistrations,
    kPairItems,
    kTrianglePairs,  ///< whose triangles are tested, of the kind that has more of them
    kContacts,
    kEarliest,
    kKept,  ///< candidates of vertex-triangle contacts, then of edge-edge contacts; likewise:
    kScreened = kKept + 2,
    kResumable = kScreened + 2,
    kCount = kResumable + 2
  };
  std::array<uint64_t, kCount> of{};

  uint64_t& operator[](size_t list) { return of[list]; }
  uint64_t operator[](size_t list) const { return of[list]; }
  uint64_t longest() const { return *std::max_element(of.begin(), of.end()); }
  bool is_known() const { return longest() > 0; }
  /// Whether a list is longer than another that was given a quarter more room has room for.
  bool exceed(const ListLengths& other) const {
    for (size_t i = 0; i < kCount; ++i)
      if (of[i] > with_reserve(other.of[i])) return true;
    return false;
  }
  static uint64_t with_reserve(uint64_t length) { return length + length / 4; }
  /// Of each list the longer.
  void include(const ListLengths& other) {
    for (size_t i = 0; i < kCount; ++i) of[i] = std::max(of[i], other.of[i]);
  }
};

/// What scenes needed, for scenes of the same triangles and options that are made later (SceneSpec::known): those of
/// the last kMost kinds of scenes. Thread-safe.
class KnownLengths {
 public:
  static constexpr size_t kMost = 256;

  /// `scene`: a hash of its triangles and options.
  ListLengths of(uint64_t scene) const;
  void learn(uint64_t scene, const ListLengths& lengths);

 private:
  struct Known {
    uint64_t scene = 0;
    ListLengths lengths;
  };

  mutable std::mutex mutex_;
  std::deque<Known> known_;  ///< what was learned last comes first
};

}  // namespace collided
