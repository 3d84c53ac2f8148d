#pragma once
// An item that takes a number of steps, on a CPU core.

#include <cstdint>

namespace collided {

/// The i-th item of for_each_resumable, from its beginning to its end.
template <class F>
void do_resumable(const F& f, uint64_t i) {
  typename F::State state;
  f.begin(i, state);
  if (state.is_over()) return;
  while (!state.is_over()) f.step(state);
  f.finish(state);
}

}  // namespace collided
