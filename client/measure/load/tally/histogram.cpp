// Times in a histogram of a fixed relative error, on Boost.Histogram, whose headers no other file needs.

#include "client/measure/load/tally/histogram.hpp"

#include <algorithm>
#include <boost/histogram/axis/regular.hpp>
#include <boost/histogram/histogram.hpp>
#include <boost/histogram/make_histogram.hpp>
#include <cmath>
#include <vector>

namespace collided::cli::load {

namespace {

namespace bh = boost::histogram;

using Axis = bh::axis::regular<double, bh::axis::transform::log>;

Axis make_axis() {
  const double bins =
      std::ceil(std::log(Histogram::kMaxMs / Histogram::kMinMs) / std::log1p(Histogram::kRelativeError));
  return Axis(static_cast<unsigned>(bins), Histogram::kMinMs, Histogram::kMaxMs);
}

auto make_bins() { return bh::make_histogram_with(std::vector<uint64_t>(), make_axis()); }

}  // namespace

struct Histogram::Bins {
  decltype(make_bins()) all = make_bins();
};

Histogram::Histogram() : bins_(std::make_unique<Bins>()) {}
Histogram::Histogram(Histogram&&) noexcept = default;
Histogram& Histogram::operator=(Histogram&&) noexcept = default;
Histogram::~Histogram() = default;

void Histogram::add(double ms) {
  ms = std::max(ms, 0.0);
  bins_->all(ms);
  min_ = count_ ? std::min(min_, ms) : ms;
  max_ = std::max(max_, ms);
  sum_ += ms;
  ++count_;
}

void Histogram::add(const Histogram& other) {
  if (other.count_ == 0) return;
  bins_->all += other.bins_->all;
  min_ = count_ ? std::min(min_, other.min_) : other.min_;
  max_ = std::max(max_, other.max_);
  sum_ += other.sum_;
  count_ += other.count_;
}

double Histogram::percentile(double percent) const {
  const auto rank = static_cast<uint64_t>(std::ceil(percent / 100 * static_cast<double>(count_)));
  const Axis& axis = bins_->all.axis();
  uint64_t below = 0;
  for (int bin = -1; bin <= axis.size(); ++bin) {
    below += bins_->all.at(bin);
    if (below >= std::max<uint64_t>(rank, 1)) return std::clamp(axis.value(bin + 1), min_, max_);
  }
  return max_;
}

}  // namespace collided::cli::load
