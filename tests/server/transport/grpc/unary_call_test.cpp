// Memory taken by unary calls.
#include "server/transport/grpc/unary_call.hpp"

#include <gtest/gtest.h>

namespace collided::server {
namespace {

TEST(UnaryCall, TheLargestMessageOfAClientFitsTheDecodeBudget) {
  constexpr uint64_t kMiB = 1 << 20;
  Limits limits;
  limits.max_decode_bytes = kMiB;
  limits.max_message_bytes = 64 * kMiB;
  EXPECT_GE(decode_budget_bytes(limits) / 2, 64 * kMiB);
  limits.max_decode_bytes = 1024 * kMiB;
  EXPECT_EQ(decode_budget_bytes(limits), 1024 * kMiB);
}

}  // namespace
}  // namespace collided::server
