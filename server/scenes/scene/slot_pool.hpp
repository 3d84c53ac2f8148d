#pragma once
// The slots of a scene's frames in flight, reused because pinned memory is expensive to allocate. No gRPC here.

#include <memory>
#include <mutex>
#include <new>
#include <vector>

#include "gpu/detector.hpp"

namespace collided::server {

class SlotPool : public std::enable_shared_from_this<SlotPool> {
 public:
  explicit SlotPool(std::shared_ptr<Detector> maker) : maker_(std::move(maker)) {}

  /// A slot that returns to the pool with its last reference. Null once the pool is closed.
  std::shared_ptr<FrameSlot> take() {
    std::shared_ptr<FrameSlot> slot = take_free();
    if (!slot) slot = make();
    if (!slot) return nullptr;
    return {slot.get(), [pool = shared_from_this(), slot](FrameSlot*) { pool->give_back(slot); }};
  }
  /// Frees idle slots now, and the others as they are returned.
  void close() {
    std::vector<std::shared_ptr<FrameSlot>> freed;
    std::shared_ptr<Detector> maker;
    const std::lock_guard lock(mutex_);
    freed.swap(free_);
    maker.swap(maker_);
  }

 private:
  std::shared_ptr<FrameSlot> take_free() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return nullptr;
    auto slot = std::move(free_.back());
    free_.pop_back();
    return slot;
  }
  std::shared_ptr<FrameSlot> make() {
    std::shared_ptr<Detector> maker;
    {
      const std::lock_guard lock(mutex_);
      maker = maker_;
    }
    return maker ? maker->make_slot() : nullptr;
  }
  /// Frees it where memory for the list is short: this is called where nothing may be thrown.
  void give_back(const std::shared_ptr<FrameSlot>& slot) try {
    const std::lock_guard lock(mutex_);
    if (maker_) free_.push_back(slot);
  } catch (const std::bad_alloc&) {
  }

  std::mutex mutex_;
  std::shared_ptr<Detector> maker_;  // null once closed
  std::vector<std::shared_ptr<FrameSlot>> free_;
};

}  // namespace collided::server
