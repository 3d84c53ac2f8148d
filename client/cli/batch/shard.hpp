#pragma once
// One of several parts of a data set, each done by a process of its own.

#include <cstdint>
#include <string>

namespace collided::cli {

constexpr uint32_t kMaxShards = 100000;

struct Shard {
  uint32_t index = 1;  ///< 1 to count
  uint32_t count = 1;

  /// Shards take turns, so that each gets its part of what is slow. Pairs count from 1.
  bool has(uint64_t pair) const { return (pair - 1) % count == index - 1; }
  /// How many of so many pairs it has.
  uint64_t size_of(uint64_t pairs) const { return pairs / count + (pairs % count >= index ? 1 : 0); }
  /// "3/16".
  std::string text() const { return std::to_string(index) + "/" + std::to_string(count); }
  /// "shard-0003-of-0016", so that names sort as shards do.
  std::string name() const;
};

/// Of "3/16". Throws UsageError.
Shard parse_shard(const std::string& word);

}  // namespace collided::cli
