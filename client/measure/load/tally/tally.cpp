// What was measured: counts of frames, and their times.

#include "client/measure/load/tally/tally.hpp"

namespace collided::cli::load {

void add(RefusalsByCode& sum, const std::string& code, const std::string& message, uint64_t count) {
  Refusals& refusals = sum[code];
  if (refusals.count == 0) refusals.first = message;
  refusals.count += count;
}

uint64_t Tally::refused_count() const {
  uint64_t count = 0;
  for (const auto& [code, refusals] : refused) count += refusals.count;
  return count;
}

Tally& Tally::operator+=(const Tally& other) {
  for (uint64_t Tally::*count : {&Tally::sent, &Tally::answered, &Tally::skipped, &Tally::unanswered, &Tally::unsent,
                                 &Tally::late, &Tally::contacts, &Tally::bytes_in, &Tally::bytes_out})
    this->*count += other.*count;
  for (const auto& [code, refusals] : other.refused) load::add(refused, code, refusals.first, refusals.count);
  for (Histogram Tally::*times : {&Tally::latency, &Tally::service, &Tally::delay, &Tally::total, &Tally::queue,
                                  &Tally::decode, &Tally::engine, &Tally::encode})
    (this->*times).add(other.*times);
  return *this;
}

Second& Second::operator+=(const Second& other) {
  sent += other.sent;
  answered += other.answered;
  skipped += other.skipped;
  refused += other.refused;
  latency.add(other.latency);
  return *this;
}

SeriesPoint point_of(double begin, double end, const Second& second) {
  return {.begin = begin,
          .end = end,
          .sent = second.sent,
          .answered = second.answered,
          .skipped = second.skipped,
          .refused = second.refused,
          .p50 = second.latency.percentile(50),
          .p99 = second.latency.percentile(99),
          .max = second.latency.max()};
}

}  // namespace collided::cli::load
