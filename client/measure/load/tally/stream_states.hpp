#pragma once
// How far streams are.

#include <cstddef>

#include "client/measure/load/tally/tally.hpp"

namespace collided::cli::load {

struct StreamStates {
  size_t opening = 0, open = 0, ended = 0;
  RefusalsByCode ends;  ///< of streams that were not told to end

  StreamStates& operator+=(const StreamStates& other) {
    opening += other.opening;
    open += other.open;
    ended += other.ended;
    for (const auto& [code, refusals] : other.ends) add(ends, code, refusals.first, refusals.count);
    return *this;
  }
};

}  // namespace collided::cli::load
