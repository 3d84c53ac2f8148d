// The table of limits: each row has an option of its own, which sets its limit in the range that the row tells.
#include "server/config/limits.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "server/config/accuracy_names.hpp"
#include "server/config/memory_limits.hpp"
#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

std::string text_of(Accuracy value) { return name_of(value); }

template <class T>
std::string text_of(T value) {
  std::ostringstream text;
  text << std::fixed << value;
  return text.str();
}

template <class T>
bool has(const Limits& limits, const LimitRow<T>& row, T expected) {
  bool found = false;
  for_each_limit(
      [&](const auto& other, const auto& limit) {
        if constexpr (std::is_same_v<std::decay_t<decltype(limit)>, T>)
          found |= std::string(other.option) == row.option && limit == expected;
      },
      limits);
  return found;
}

TEST(LimitRows, EachSetsItsLimitByItsOption) {
  for_each_limit([](const auto& row) {
    // A lease by default may not be longer than the longest, so it is tried at its lowest.
    const bool is_lowest = std::string(row.option) == "lease-seconds" || std::string(row.option) == "max-accuracy";
    const auto value = is_lowest ? row.min : row.max;
    const auto parsed = parse({row.flag().c_str(), text_of(value).c_str()});
    ASSERT_TRUE(parsed.run) << parsed.text;
    EXPECT_TRUE(has(parsed.config.limits, row, row.limit_of(value))) << row.option;
    Limits others = parsed.config.limits, defaults = underived_limits();
    const auto forget = [&](const auto& other, auto& now, auto& before) {
      if (std::string(other.option) == row.option) now = before = {};
    };
    for_each_limit(forget, others, defaults);
    EXPECT_EQ(others, defaults) << row.option << " sets another limit, too";
  });
}

TEST(LimitRows, EachRefusesWhatIsBeyondItsRange) {
  for_each_limit([](const auto& row) {
    if constexpr (std::is_arithmetic_v<decltype(row.max)>) {
      const auto parsed = parse({row.flag().c_str(), text_of(static_cast<decltype(row.max)>(row.max * 10)).c_str()});
      EXPECT_EQ(parsed.exit_code, 2) << row.option;
      EXPECT_NE(parsed.text.find(row.flag()), std::string::npos) << parsed.text;
    }
  });
}

TEST(LimitRows, ADerivedOneIsUnsetUntilItIsDerived) {
  for_each_limit(
      [](const auto& row, const auto& unset) {
        EXPECT_EQ(row.is_derived(), unset == std::decay_t<decltype(unset)>{}) << row.option;
      },
      underived_limits());
}

}  // namespace
}  // namespace collided::server
