// The search for the highest rate that holds a bound.

#include "client/measure/load/search.hpp"

#include <algorithm>
#include <cmath>

namespace collided::cli::load {

RateSearch::RateSearch(double first, double precision)
    : precision_(precision), rate_(std::clamp(first, kMinRate, kMaxRate)) {}

std::optional<double> RateSearch::next() const {
  const bool is_narrow = held_ && failed_ && *failed_ <= *held_ * (1 + precision_);
  const bool is_at_end = (held_ && *held_ >= kMaxRate) || (failed_ && *failed_ <= kMinRate);
  if (is_narrow || is_at_end) return std::nullopt;
  return rate_;
}

void RateSearch::report(bool held) {
  failed_once_ = !held && !failed_once_;
  if (failed_once_) return;
  (held ? held_ : failed_) = rate_;
  if (held_ && failed_)
    rate_ = std::sqrt(*held_ * *failed_);
  else
    rate_ = std::clamp(held ? 2 * rate_ : rate_ / 2, kMinRate, kMaxRate);
}

}  // namespace collided::cli::load
