// Fair turns on a shared device: start-time fair queuing, with the time that a frame took as its weight.
#include "server/scenes/turns.hpp"

#include <algorithm>
#include <chrono>

#include "gpu/detector.hpp"

namespace collided::server {
namespace {

constexpr auto kLookForCancel = std::chrono::milliseconds(10);

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Turns::Turn::Turn(Turns* turns, TurnAccount* account) : turns_(turns), account_(account), start_(seconds_now()) {}

Turns::Turn::~Turn() {
  if (turns_ != nullptr) turns_->end(*account_, seconds_now() - start_);
}

Turns::Turn Turns::take(TurnAccount& account, const std::function<bool()>& cancelled) {
  Waiter waiter{&account, {}};
  std::unique_lock lock(mutex_);
  account.used_ = std::max(account.used_, now_);
  const auto place = waiting_.insert(waiting_.end(), &waiter);
  while (!is_next(waiter)) {
    waiter.called.wait_for(lock, kLookForCancel);
    if (!cancelled || !cancelled()) continue;
    waiting_.erase(place);
    call_next();
    throw Cancelled();
  }
  waiting_.erase(place);
  --free_;
  now_ = account.used_;
  call_next();
  return {this, &account};
}

// Of equals, the one that came first.
bool Turns::is_next(const Waiter& waiter) const {
  if (free_ == 0) return false;
  const auto first = std::min_element(waiting_.begin(), waiting_.end(), [](const Waiter* a, const Waiter* b) {
    return a->account->used_ < b->account->used_;
  });
  return *first == &waiter;
}

void Turns::call_next() {
  for (Waiter* waiter : waiting_)
    if (is_next(*waiter)) return waiter->called.notify_one();
}

void Turns::end(TurnAccount& account, double seconds) {
  std::lock_guard lock(mutex_);
  account.used_ += seconds;
  ++free_;
  call_next();
}

}  // namespace collided::server
