#pragma once
// Who holds how many bytes of a scene's budget. Slots book theirs from other threads than the scene.

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "gpu/types.hpp"

namespace collided {

/// What a scene may hold.
struct MemoryLimits {
  MemoryLimits(uint64_t budget, std::shared_ptr<MemoryQuota> quota = {}) : budget(budget), quota(std::move(quota)) {}
  uint64_t budget;                     ///< bytes; 0: as many as there are
  std::shared_ptr<MemoryQuota> quota;  ///< shared with other scenes; may be empty
};

class MemoryLedger {
 public:
  explicit MemoryLedger(MemoryLimits limits) : budget_(limits.budget), quota_(std::move(limits.quota)) {}
  MemoryLedger(const MemoryLedger&) = delete;
  MemoryLedger& operator=(const MemoryLedger&) = delete;

  /// Throws ResourceExhausted if `bytes` more would pass the budget, and what the quota throws; else books them.
  void take(const std::string& part, uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    if (budget_ != 0 && bytes > budget_ - std::min(budget_, total_))
      throw ResourceExhausted("memory_budget: the scene needs at least " + std::to_string(total_ + bytes) + " bytes (" +
                              part + ": " + std::to_string(bytes) + " beside the " + std::to_string(total_) +
                              " that it holds), the budget is " + std::to_string(budget_));
    if (quota_) quota_->take(bytes);
    parts_[part] += bytes;
    total_ += bytes;
  }

  void give_back(const std::string& part, uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    parts_[part] -= bytes;
    total_ -= bytes;
    if (quota_) quota_->give_back(bytes);
  }

  /// Memory of the host beside that of the backend: for the quota alone, since the budget is the backend's. Throws what
  /// the quota throws.
  void take_pinned(uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    if (quota_) quota_->take(bytes);
    pinned_ += bytes;
  }

  void give_back_pinned(uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    pinned_ -= bytes;
    if (quota_) quota_->give_back(bytes);
  }

  std::vector<MemoryPart> parts() const {
    const std::lock_guard lock(mutex_);
    std::vector<MemoryPart> out;
    for (const auto& [part, bytes] : parts_)
      if (bytes != 0) out.push_back({part, bytes});
    if (pinned_ != 0) out.push_back({"pinned", pinned_});
    return out;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, uint64_t> parts_;
  uint64_t total_ = 0, pinned_ = 0;
  const uint64_t budget_;
  const std::shared_ptr<MemoryQuota> quota_;
};

}  // namespace collided
