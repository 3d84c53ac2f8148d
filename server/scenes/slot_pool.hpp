#pragma once
// The slots of a scene's frames in flight, used again and again: pinned memory is dear to get. No gRPC here.

#include <memory>
#include <mutex>
#include <vector>

#include "gpu/detector.hpp"

namespace collided::server {

class SlotPool : public std::enable_shared_from_this<SlotPool> {
 public:
  explicit SlotPool(std::shared_ptr<Detector> maker) : maker_(std::move(maker)) {}

  /// Comes back to the pool when it is let go. Null once closed.
  std::shared_ptr<FrameSlot> take() {
    std::shared_ptr<FrameSlot> slot = take_free();
    if (!slot) slot = make();
    if (!slot) return nullptr;
    return {slot.get(), [pool = shared_from_this(), slot](FrameSlot*) { pool->give_back(slot); }};
  }
  /// Frees what is free now, and takes nothing back any more.
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
  void give_back(const std::shared_ptr<FrameSlot>& slot) {
    const std::lock_guard lock(mutex_);
    if (maker_) free_.push_back(slot);
  }

  std::mutex mutex_;
  std::shared_ptr<Detector> maker_;  // null once closed
  std::vector<std::shared_ptr<FrameSlot>> free_;
};

}  // namespace collided::server
