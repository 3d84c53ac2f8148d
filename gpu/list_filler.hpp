#pragma once
// Lists whose length is not known before they are made.

#include "gpu/exec/atomic.hpp"
#include "gpu/exec/buffer.hpp"

namespace collided {

/// Runs a stage that appends to a list; if the list was too small, grows it to the need and runs it again.
/// Returns the length.
template <class Exec, class T, class Run>
uint64_t fill_list(Exec& exec, Buffer<T, Exec>& list, Buffer<uint64_t, Exec>& count, uint32_t& replays,
                   const Run& run) {
  count.allocate(1);
  for (;;) {
    exec.fill_zero(count.data(), sizeof(uint64_t));
    run(AppendList<T>{list.all(), count.data()});
    const uint64_t need = exec.read(count.data());
    if (need <= list.capacity()) return need;
    list.ensure(need);
    ++replays;
  }
}

}  // namespace collided
