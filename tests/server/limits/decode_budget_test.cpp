// Memory for messages, shared fairly among clients.
#include "server/limits/decode_budget.hpp"

#include <gtest/gtest.h>

#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMiB = 1 << 20;

Client client(const char* name) { return std::make_shared<const ClientIdentity>(ClientIdentity{name, {}}); }

/// The subject of the refusal.
std::string refused(DecodeBudget& budget, const char* name, uint64_t bytes) {
  try {
    budget.take(client(name), bytes);
  } catch (const LimitExceeded& e) {
    EXPECT_GT(e.retry_after_seconds(), 0);
    EXPECT_NE(std::string(e.what()).find("max-decode-mb"), std::string::npos) << e.what();
    return e.subject();
  }
  return "";
}

TEST(DecodeBudget, OneClientTakesHalfAtMost) {
  DecodeBudget budget(256 * kMiB);
  const auto held = budget.take(client("a"), 128 * kMiB);
  EXPECT_EQ(refused(budget, "a", 1), "client:a");
  EXPECT_EQ(refused(budget, "b", 128 * kMiB), "");
}

TEST(DecodeBudget, AllTogetherTakeNoMoreThanThereIs) {
  DecodeBudget budget(256 * kMiB);
  const auto a = budget.take(client("a"), 128 * kMiB), b = budget.take(client("b"), 100 * kMiB);
  EXPECT_EQ(refused(budget, "c", 29 * kMiB), "daemon");
  EXPECT_EQ(refused(budget, "c", 28 * kMiB), "");
}

TEST(DecodeBudget, WhatIsGivenBackIsThereAgain) {
  DecodeBudget budget(256 * kMiB);
  for (int i = 0; i < 10; ++i) budget.take(client("a"), 128 * kMiB);
  EXPECT_EQ(refused(budget, "a", 128 * kMiB), "");
  EXPECT_EQ(refused(budget, "a", 129 * kMiB), "client:a");
}

}  // namespace
}  // namespace collided::server
