#pragma once
// Loops that CPU cores share (oneTBB). When it is time to ask whether the frame goes on, every thread leaves what it
// holds of the loop's items; the calling thread asks, and they go on with what is left.

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "gpu/exec/asks.hpp"

namespace collided {

/// Items [first, end); `part` tells how much of the first one is done, if its loop can leave an item half done.
struct ItemRange {
  uint64_t first = 0, end = 0, part = 0;

  uint64_t size() const { return end - first; }
  bool is_over() const { return first == end; }
};

/// The items of a loop that no thread holds. Each thread has a part of its own first: neighbours among the items have
/// much in common (cells that they count, say), which threads that share them would fight for. Then it helps others.
class SharedItems {
 public:
  /// `grain`: items that a thread takes at least.
  SharedItems(uint64_t count, uint64_t grain, uint64_t threads) : grain_(grain) {
    const uint64_t each = count / threads, more = count % threads;
    for (uint64_t k = 0, first = 0; k < threads; ++k) {
      const uint64_t end = first + each + (k < more ? 1 : 0);
      parts_.push_back({first, end});
      first = end;
    }
  }

  /// For thread `thread` of them; false if there are none.
  bool take(uint64_t thread, ItemRange& range) {
    const std::lock_guard lock(mutex_);
    if (!left_.empty()) {
      range = left_.back();
      left_.pop_back();
      return true;
    }
    ItemRange& part = parts_[thread];
    if (part.is_over()) part = take_from_others();
    constexpr uint64_t kShares = 8, kMaxGrains = 64;
    const uint64_t size = std::clamp(part.size() / kShares, grain_, kMaxGrains * grain_);
    range = {part.first, std::min(part.end, part.first + size)};
    part.first = range.end;
    return !range.is_over();
  }
  void give_back(const ItemRange& range) {
    if (range.is_over()) return;
    const std::lock_guard lock(mutex_);
    left_.push_back(range);
  }
  /// While no thread holds any.
  bool are_left() const {
    return !left_.empty() ||
           !std::all_of(parts_.begin(), parts_.end(), [](const auto& part) { return part.is_over(); });
  }

 private:
  /// Half of what the thread with most has, or all if that is little.
  ItemRange take_from_others() {
    const auto smaller = [](const ItemRange& a, const ItemRange& b) { return a.size() < b.size(); };
    ItemRange& most = *std::max_element(parts_.begin(), parts_.end(), smaller);
    const uint64_t kept = most.size() > grain_ ? most.size() / 2 : 0;
    const ItemRange taken{most.first + kept, most.end};
    most.end = taken.first;
    return taken;
  }

  std::mutex mutex_;
  const uint64_t grain_;
  std::vector<ItemRange> parts_;  ///< of each thread
  std::vector<ItemRange> left_;   ///< that threads gave back
};

/// What a loop's threads know of each other.
struct LoopState {
  SharedItems items;
  Asks& asks;
  std::atomic<int> helpers = 0;  ///< at work, beside the calling thread
};

/// Ends a helper's item that takes long; it is done from its beginning another time.
struct LeftUndone {};

/// A thread's work on a loop, until there are no more items or it is time to ask.
class LoopTurn {
 public:
  static constexpr uint64_t kCaller = 0;
  /// `thread`: kCaller, or a helper's number. The calling thread has items from the beginning: what no helper can do in
  /// the time that it has, is done by it.
  LoopTurn(LoopState& loop, uint64_t thread) : loop_(loop), thread_(thread), is_helper_(thread != kCaller) {
    is_helper_ ? void(++loop_.helpers) : void(loop_.items.take(thread_, range_));
  }
  LoopTurn(const LoopTurn&) = delete;
  LoopTurn& operator=(const LoopTurn&) = delete;
  ~LoopTurn() {
    loop_.items.give_back(range_);
    if (is_helper_) --loop_.helpers;
  }

  /// Items to do some of: who uses the turn moves `first` on, and calls again after a bounded time. Null: it is over.
  ItemRange* next() {
    if ((is_helper_ || has_begun_) && loop_.asks.is_due()) return nullptr;
    has_begun_ = true;
    return range_.is_over() && !loop_.items.take(thread_, range_) ? nullptr : &range_;
  }

  /// Within an item that takes long. When it is time to ask, a helper leaves the item (LeftUndone); the calling thread
  /// waits until the helpers rest, asks, and goes on.
  void look_up() {
    if (!loop_.asks.is_due()) return;
    if (is_helper_) throw LeftUndone();
    while (loop_.helpers != 0) std::this_thread::yield();
    loop_.asks.ask();
  }

 private:
  LoopState& loop_;
  const uint64_t thread_;
  const bool is_helper_;
  ItemRange range_;
  bool has_begun_ = false;
};

class CpuLoops {
 public:
  explicit CpuLoops(int threads) : arena_(threads > 0 ? threads : tbb::task_arena::automatic) {}

  int threads() const { return arena_.max_concurrency(); }

  /// use(turn) on several threads, until all of `count` items are done. Throws what the question throws.
  template <class Use>
  void share(uint64_t count, uint64_t grain, const Use& use) {
    const uint64_t most = (count + grain - 1) / grain, threads = std::min<uint64_t>(arena_.max_concurrency(), most);
    LoopState loop{{count, grain, std::max<uint64_t>(threads, 1)}, asks};
    asks.ask_if_due();
    while (loop.items.are_left()) {
      if (threads > 1)
        arena_.execute([&] { work_together(loop, threads - 1, use); });
      else
        work(loop, LoopTurn::kCaller, use);
      if (loop.items.are_left()) asks.ask();
    }
  }

  /// f(first, end) for ranges of [0, count). `grain`: items that take a bounded time together, at most of a range.
  template <class F>
  void for_each_range(uint64_t count, uint64_t grain, const F& f) {
    share(count, grain, [&](LoopTurn& turn) {
      while (ItemRange* items = turn.next()) {
        const uint64_t end = std::min(items->end, items->first + grain);
        f(items->first, end);
        items->first = end;
      }
    });
  }
  /// f(i) for i in [0, count).
  template <class F>
  void for_each(uint64_t count, uint64_t grain, const F& f) {
    for_each_range(count, grain, [&](uint64_t first, uint64_t end) {
      for (uint64_t i = first; i != end; ++i) f(i);
    });
  }

  /// op over transform(i), i in [0, count); op must not depend on the order.
  template <class T, class F, class Op>
  T reduce(uint64_t count, uint64_t grain, const F& transform, const T& identity, const Op& op) {
    T all = identity;
    std::mutex mutex;
    share(count, grain, [&](LoopTurn& turn) {
      T value = identity;
      while (ItemRange* items = turn.next()) {
        const uint64_t end = std::min(items->end, items->first + grain);
        for (uint64_t i = items->first; i != end; ++i) value = op(value, transform(i));
        items->first = end;
      }
      const std::lock_guard lock(mutex);
      all = op(all, value);
    });
    return all;
  }

  /// f(first, end) for ranges of [0, count) in turn, on the calling thread alone.
  template <class F>
  void in_turn(uint64_t count, uint64_t grain, const F& f) {
    for (uint64_t first = 0; first < count; first += grain) {
      asks.ask_if_due();
      f(first, std::min(count, first + grain));
    }
  }

  Asks asks;

 private:
  template <class Use>
  static void work(LoopState& loop, uint64_t thread, const Use& use) {
    LoopTurn turn(loop, thread);
    use(turn);
  }
  template <class Use>
  static void work_together(LoopState& loop, uint64_t helpers, const Use& use) {
    tbb::task_group group;
    LoopTurn turn(loop, LoopTurn::kCaller);
    group.run([&] { tbb::parallel_for(uint64_t{1}, helpers + 1, [&](uint64_t thread) { work(loop, thread, use); }); });
    try {
      use(turn);
    } catch (...) {
      group.wait();
      throw;
    }
    group.wait();
  }

  tbb::task_arena arena_;
};

}  // namespace collided
