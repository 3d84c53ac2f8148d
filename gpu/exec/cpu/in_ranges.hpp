#pragma once
// Functors that CPU cores run on several items at once, where that takes less time than one by one.

#include <concepts>
#include <cstdint>

namespace collided {

/// Specialised, for a functor F, with a static run(f, first, end) that does what F does for the items [first, end), in
/// any order; and kItems, how many of them take a bounded time together.
template <class F>
struct InRanges {};

template <class F>
concept HasRanges = requires(const F& f, uint64_t i) {
  InRanges<F>::run(f, i, i);
  { InRanges<F>::kItems } -> std::convertible_to<uint64_t>;
};

}  // namespace collided
