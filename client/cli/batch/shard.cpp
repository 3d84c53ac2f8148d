// One of several parts of a data set.

#include "client/cli/batch/shard.hpp"

#include <charconv>

#include "client/app/options/usage_error.hpp"

namespace collided::cli {

namespace {

std::string four_digits(uint32_t number) {
  const std::string text = std::to_string(number);
  return text.size() < 4 ? std::string(4 - text.size(), '0') + text : text;
}

/// Digits alone: no sign, no blank. Nothing of a number too large is kept but that it is.
uint32_t number_in(std::string_view digits, const std::string& word) {
  uint32_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const bool is_whole = !digits.empty() && end == digits.data() + digits.size();
  if (is_whole && error == std::errc::result_out_of_range) return UINT32_MAX;
  if (!is_whole || error != std::errc())
    throw UsageError("--shard " + word + ": is not I/N, two whole numbers such as 3/16");
  return number;
}

}  // namespace

std::string Shard::name() const { return "shard-" + four_digits(index) + "-of-" + four_digits(count); }

Shard parse_shard(const std::string& word) {
  const size_t slash = word.find('/');
  if (slash == std::string::npos) throw UsageError("--shard " + word + ": is not I/N, two whole numbers such as 3/16");
  const std::string_view text = word;
  const Shard shard{number_in(text.substr(0, slash), word), number_in(text.substr(slash + 1), word)};
  if (shard.count < 1 || shard.count > kMaxShards)
    throw UsageError("--shard " + word + ": there are 1 to " + std::to_string(kMaxShards) + " shards");
  if (shard.index < 1 || shard.index > shard.count)
    throw UsageError("--shard " + word + ": shards count from 1, here 1/" + std::to_string(shard.count) + " to " +
                     std::to_string(shard.count) + "/" + std::to_string(shard.count) +
                     "; add 1 to an index that counts from 0");
  return shard;
}

}  // namespace collided::cli
