#pragma once
// Measures the scene and its triangles before anything is built. In a shard of a scene (base/share.hpp) this also
// leaves out the triangles that are in none of its pairs: from there on their boxes meet nothing.

#include "gpu/base/extent.hpp"
#include "gpu/base/mesh_filter.hpp"
#include "gpu/base/share.hpp"
#include "gpu/boxes/boxes.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/exec/concepts.hpp"

namespace collided {

/// The blocks of the step.
struct ChooseBlocks {
  const Box<float>* bounds;
  const uint64_t* extents;
  uint64_t triangles;
  Share* share;

  COLLIDED_HD void operator()(uint64_t) const {
    share->grid = grid_over(*bounds, 0, 0);
    share->level = block_level(*extents / triangles);
  }
};

struct LeaveOutOthers {
  const Share* share;
  Span<Box<float>> boxes;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (!share->touches(boxes[i])) boxes[i] = no_box();
  }
};

/// Takes the boxes of triangles of idle meshes (IdleMeshes) away, so that no search meets them.
struct LeaveOutIdle {
  PairFilter filter;
  Span<Box<float>> boxes;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (filter.is_idle(static_cast<uint32_t>(i))) boxes[i] = no_box();
  }
};

/// What a shard of a scene has of it.
template <Executor Exec>
class ResidentShare {
 public:
  explicit ResidentShare(Exec& exec) : resident_(exec, "counters") {}

  /// Makes the scene a shard, which has this share from the next step on.
  void take(const ShareRange& range) {
    resident_.allocate(1);
    own_ = range;
  }
  bool is_shard() const { return resident_.capacity() > 0; }
  /// Null where the scene is no shard. It stays where it is.
  Share* data() const { return resident_.data(); }

  /// Before a step that is of the shard's own pairs.
  void send(Exec& exec) { send(exec, own_); }
  /// Before one that is of all.
  void send_all(Exec& exec) { send(exec, {}); }

 private:
  void send(Exec& exec, const ShareRange& range) {
    if (!is_shard()) return;
    sent_ = range;
    exec.upload(&data()->range, &sent_, sizeof(sent_));
  }

  Buffer<Share, Exec> resident_;
  ShareRange own_, sent_;
};

/// Of all triangles.
struct SceneSize {
  Span<Box<float>> boxes;
  Box<float>* bounds;  ///< where they go
  uint64_t* extents;   ///< likewise; the sum
  Share* share;        ///< null: the scene is no shard
};

/// The bounds, and then then(0).
template <Executor Exec, class Then = NothingMore>
void measure_bounds(Exec& exec, const SceneSize& size, const Then& then = {}) {
  const uint64_t count = size.boxes.size();
  const BoxOf box_of{size.boxes};
  if (size.share == nullptr)
    return exec.reduce_into("bounds", count, box_of, empty_box(), JoinBoxes{}, size.bounds, then);
  exec.reduce_into("bounds", count, box_of, empty_box(), JoinBoxes{}, size.bounds);
  exec.reduce_into("extents", count, ExtentOf{size.bounds, size.boxes}, uint64_t{0}, AddExtents{}, size.extents,
                   ChooseBlocks{size.bounds, size.extents, count, size.share});
  exec.for_each("leave_out_others", count, LeaveOutOthers{size.share, size.boxes});
  if constexpr (!std::is_same_v<Then, NothingMore>) exec.for_each("prepare", 1, then);
}
/// The extents, once the bounds are known, and then then(0).
template <Executor Exec, class Then>
void measure_extents(Exec& exec, const SceneSize& size, const Then& then) {
  if (size.share != nullptr) return exec.for_each("prepare", 1, then);
  exec.reduce_into("extents", size.boxes.size(), ExtentOf{size.bounds, size.boxes}, uint64_t{0}, AddExtents{},
                   size.extents, then);
}

}  // namespace collided
