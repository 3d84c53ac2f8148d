// When each frame of one stream should be sent.

#include "client/measure/load/pace/schedule.hpp"

#include <cmath>

namespace collided::cli::load {

namespace {

std::mt19937_64 seeded(uint64_t seed, uint32_t stream) {
  std::seed_seq words{static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32), stream};
  return std::mt19937_64(words);
}

/// In [0, 1), the same with every standard library.
double uniform(std::mt19937_64& random) { return std::ldexp(static_cast<double>(random() >> 11), -53); }

}  // namespace

Schedule::Schedule(const RateProfile& profile, Arrivals arrivals, StreamPlace place, uint64_t seed)
    : profile_(profile), arrivals_(arrivals), random_(seeded(seed, place.index)) {
  due_ = arrivals == Arrivals::kFixed ? static_cast<double>(place.index) / place.count : gap();
}

double Schedule::gap() { return arrivals_ == Arrivals::kFixed ? 1 : -std::log1p(-uniform(random_)); }

double Schedule::next() {
  const double time = profile_.time_of(due_);
  due_ += gap();
  return time;
}

}  // namespace collided::cli::load
