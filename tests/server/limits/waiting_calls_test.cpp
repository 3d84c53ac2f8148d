// Calls that wait for their client.
#include "server/limits/waiting_calls.hpp"

#include <gtest/gtest.h>

#include <future>

#include "server/refusals/status.hpp"

namespace collided::server {
namespace {

constexpr double kForEver = 1e6;

Client client(const char* name) { return std::make_shared<const ClientIdentity>(ClientIdentity{name, {}}); }

/// How a wait ends.
struct Ended {
  std::promise<Failure> promise;
  std::future<Failure> failure = promise.get_future();
  WaitingCalls::End end = [this](const std::exception_ptr& why) { promise.set_value(describe(why)); };

  bool is_ready() const { return failure.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }
};

TEST(WaitingCalls, OneThatIsLateIsEnded) {
  WaitingCalls calls;
  Ended ended;
  const auto wait = calls.wait({"the word", 0.01, 8, 8}, client("a"), ended.end);
  const Failure failure = ended.failure.get();
  EXPECT_EQ(failure.code, grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(failure.message, "the word did not come within 0.01 s");
  EXPECT_FALSE(wait->finish());
}

TEST(WaitingCalls, OneThatIsOverIsNotEnded) {
  WaitingCalls calls;
  Ended first, second;
  const auto wait = calls.wait({"a word", 0.01, 8, 8}, client("a"), first.end);
  const bool in_time = wait->finish();
  const auto later = calls.wait({"a word", 0.02, 8, 8}, client("a"), second.end);
  second.failure.get();
  EXPECT_NE(in_time, first.is_ready());  // exactly one of the two, even on a busy machine
  EXPECT_EQ(calls.waiting(), 0u);
}

TEST(WaitingCalls, TheOldestOfAClientGoesForItsNext) {
  WaitingCalls calls;
  const WaitRule rule{"a word", kForEver, 8, 2};
  Ended ended[4];
  const auto other = calls.wait(rule, client("b"), ended[0].end);
  const auto first = calls.wait(rule, client("a"), ended[1].end), second = calls.wait(rule, client("a"), ended[2].end);
  const auto third = calls.wait(rule, client("a"), ended[3].end);
  EXPECT_EQ(ended[1].failure.get().code, grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_FALSE(ended[0].is_ready() || ended[2].is_ready() || ended[3].is_ready());
  EXPECT_TRUE(second->finish() && third->finish() && other->finish());
}

TEST(WaitingCalls, WhereAllAreTooManyTheClientWithMostGivesOne) {
  WaitingCalls calls;
  WaitRule rule{"a word", kForEver, 3, 3};
  Ended ended[4];
  const auto honest = calls.wait(rule, client("a"), ended[0].end);
  rule.source = "elsewhere";
  const auto first = calls.wait(rule, client("a"), ended[1].end), second = calls.wait(rule, client("a"), ended[2].end);
  const auto third = calls.wait(rule, client("b"), ended[3].end);
  EXPECT_TRUE(ended[1].is_ready());
  EXPECT_TRUE(honest->finish() && second->finish() && third->finish());
}

TEST(WaitingCalls, TheOldestOfAllGoesWhereAllAreTooMany) {
  WaitingCalls calls;
  const WaitRule rule{"a word", kForEver, 2, 2};
  Ended ended[3];
  const auto first = calls.wait(rule, client("a"), ended[0].end), second = calls.wait(rule, client("b"), ended[1].end);
  const auto unlike = calls.wait({"another word", kForEver, 1, 1}, client("a"), [](const auto&) { FAIL(); });
  const auto third = calls.wait(rule, client("c"), ended[2].end);
  EXPECT_TRUE(ended[0].is_ready());
  EXPECT_FALSE(first->finish());
  EXPECT_TRUE(second->finish() && third->finish() && unlike->finish());
}

}  // namespace
}  // namespace collided::server
