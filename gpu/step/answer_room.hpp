#pragma once
// Room on the host for a scene's answers. Like the scene's buffers it grows to the need and stays, so that a frame like
// the last is never refused for what others have taken since.

#include <memory>
#include <mutex>
#include <utility>

#include "gpu/types.hpp"

namespace collided {

/// Answers take their bytes here, and may outlive the scene.
class AnswerRoom final : public MemoryQuota {
 public:
  explicit AnswerRoom(std::shared_ptr<MemoryQuota> quota) : quota_(std::move(quota)) {}

  /// Throws what the scene's quota throws.
  void take(uint64_t bytes) override {
    const std::lock_guard lock(mutex_);
    if (used_ + bytes > held_.bytes()) held_.resize(used_ + bytes);
    used_ += bytes;
  }
  void give_back(uint64_t bytes) noexcept override {
    const std::lock_guard lock(mutex_);
    used_ -= bytes;
    if (is_closed_) held_.resize(used_);
  }
  /// The scene is gone: from now on only what answers use is held.
  void close() {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
    held_.resize(used_);
  }
  uint64_t bytes() const {
    const std::lock_guard lock(mutex_);
    return held_.bytes();
  }

 private:
  mutable std::mutex mutex_;
  const std::shared_ptr<MemoryQuota> quota_;
  MemoryHold held_{quota_};
  uint64_t used_ = 0;
  bool is_closed_ = false;
};

}  // namespace collided
