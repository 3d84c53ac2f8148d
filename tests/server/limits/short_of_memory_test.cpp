// Whichever allocation fails: what was accepted is done, what was refused is not, and no turn is lost.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "server/limits/client_work.hpp"
#include "server/limits/waiting_calls.hpp"
#include "tests/server/wait_until.hpp"

namespace {

thread_local int allocations_left = -1;  // before each of this thread fails; negative: none does

void* allocate(size_t bytes) {
  if (allocations_left == 0) throw std::bad_alloc();
  if (allocations_left > 0) --allocations_left;
  void* const memory = std::malloc(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(size_t bytes) { return allocate(bytes); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace collided::server {
namespace {

/// Runs `use`, whose allocations fail after the first `count`. Whether it needed no more.
template <class Use>
bool with_allocations(int count, const Use& use) {
  allocations_left = count;
  try {
    use();
  } catch (const std::bad_alloc&) {
    allocations_left = -1;
    return false;
  }
  allocations_left = -1;
  return true;
}

constexpr int kMore = 40;  // allocations than any of these needs

TEST(ShortOfMemory, WorkThatIsAcceptedIsDone) {
  Turns turns(2);
  ClientWork work(turns);
  std::atomic<int> done = 0;
  int accepted = 0, refused = 0;
  for (int count = 0; count < kMore; ++count)
    for (int client = 0; client < 10; ++client) {
      const TurnPath path{"host", "client " + std::to_string(client)};
      const bool is_accepted = with_allocations(count, [&] { work.post(path, [&] { ++done; }); });
      ++(is_accepted ? accepted : refused);
    }
  EXPECT_GT(accepted, 10);
  EXPECT_GT(refused, 10);
  EXPECT_TRUE(wait_until([&] { return work.size() == 0; }));
  EXPECT_EQ(done, accepted);

  TurnAccount one = turns.account({"one"}), other = turns.account({"other"});
  const Turns::Turn first = turns.take(one), second = turns.take(other);  // both are still there
}

TEST(ShortOfMemory, TurnsThatWaitAreGranted) {
  for (int count = 0; count < kMore; ++count) {
    Turns turns(1);
    TurnAccount holder = turns.account({"holder"});
    std::optional<Turns::Turn> held(turns.take(holder));
    std::vector<TurnAccount> accounts;
    for (int i = 0; i < 8; ++i) accounts.push_back(turns.account({"client " + std::to_string(i)}));
    std::optional<Turns::Turn> granted[8];
    size_t waiting = 0;
    for (int i = 0; i < 8; ++i)
      waiting += with_allocations(count, [&] {
        turns.request(accounts[i], [&granted = granted[i]](Turns::Turn turn) { granted.emplace(std::move(turn)); });
      });
    EXPECT_EQ(turns.waiting(), waiting);
    allocations_left = 0;  // to grant and to end needs none
    held.reset();
    size_t turns_of_all = 0;
    for (bool is_any = true; is_any;) {
      is_any = false;
      for (auto& turn : granted)
        if (turn) is_any = true, ++turns_of_all, turn.reset();
    }
    allocations_left = -1;
    EXPECT_EQ(turns_of_all, waiting);
  }
}

TEST(ShortOfMemory, CallsThatWaitAreEndedOnce) {
  const auto client = std::make_shared<const ClientIdentity>(ClientIdentity{"a", {}});
  WaitingCalls calls;
  const WaitRule rule{"a word that does not fit a short string", 1e6, 3, 3};
  std::vector<std::unique_ptr<WaitingCalls::Wait>> waits(kMore);
  std::atomic<size_t> ended = 0;
  size_t accepted = 0;
  for (int count = 0; count < kMore; ++count) {
    with_allocations(count, [&] { waits[count] = calls.wait(rule, client, [&](const auto&) { ++ended; }); });
    if (waits[count]) ++accepted;
    EXPECT_EQ(calls.waiting() + ended, accepted) << "with " << count << " allocations";
  }
  EXPECT_GT(accepted, 3u);
  waits.clear();
  EXPECT_EQ(calls.waiting(), 0u);
}

}  // namespace
}  // namespace collided::server
