// Whether contacts are the same, in sixteen digits.

#include "client/app/report/digest.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace collided::cli {

/// A multiplication for every eight bytes.
template <class T>
void ContactsDigest::add(const std::vector<T>& values) {
  constexpr uint64_t kPrime = 0x9e3779b97f4a7c15;
  const uint64_t bytes = values.size() * sizeof(T);
  digest_ = (digest_ ^ bytes) * kPrime;
  for (uint64_t at = 0; at < bytes; at += sizeof(uint64_t)) {
    uint64_t word = 0;
    std::memcpy(&word, reinterpret_cast<const char*>(values.data()) + at, std::min(sizeof word, bytes - at));
    digest_ = (digest_ ^ word) * kPrime;
    digest_ ^= digest_ >> 32;
  }
}

void ContactsDigest::add(const client::FrameOutput& output) {
  for_each_kind(
      [&](v1::ContactKind, const client::Contacts& contacts) {
        client::for_each_column([&](v1::ContactField, auto column) { add(contacts.*column); });
      },
      output);
}

std::string ContactsDigest::text() const {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(digest_));
  return text;
}

}  // namespace collided::cli
