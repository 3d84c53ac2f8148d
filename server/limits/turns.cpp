// Whose frame runs next: start-time fair queuing, a quantum at a time.
#include "server/limits/turns.hpp"

#include <algorithm>
#include <utility>

#include "gpu/detector.hpp"

namespace collided::server {
namespace {

constexpr auto kCancelPoll = std::chrono::milliseconds(10);
constexpr size_t kWaitersOfOnePoll = 16;

/// How long each of so many waits before it asks whether it is cancelled. Each asks by itself: the more there are, the
/// less often, so that a thousand do not keep the processors busy with asking.
std::chrono::milliseconds poll_of(size_t waiters) { return kCancelPoll * (1 + waiters / kWaitersOfOnePoll); }

}  // namespace

Turns::Turn::~Turn() {
  if (turns_ == nullptr) return;
  const std::lock_guard lock(turns_->mutex_);
  turns_->end(*account_);
}

double Turns::Turn::seconds() const {
  const std::lock_guard lock(turns_->mutex_);
  turns_->charge_running();
  return account_->turn_seconds_;
}

void Turns::Turn::yield_turn(const std::function<bool()>& cancelled) {
  Lock lock(turns_->mutex_);
  turns_->charge_running();
  if (account_->charged_until_ - account_->quantum_begin_ < kQuantum) return;
  turns_->begin_quantum(*account_);
  if (!turns_->should_yield(*account_)) return;
  Turns& turns = *std::exchange(turns_, nullptr);
  turns.end(*account_);
  turns.await(lock, *account_, cancelled);
  turns_ = &turns;
}

TurnAccount Turns::account(const std::string& client) {
  const std::lock_guard lock(mutex_);
  std::erase_if(clients_, [](const auto& known) { return known.second.expired(); });
  auto& known = clients_[client];
  auto alive = known.lock();
  if (!alive) known = alive = std::make_shared<TurnClient>();
  return TurnAccount(std::move(alive));
}

Turns::Turn Turns::take(TurnAccount& account, const std::function<bool()>& cancelled) {
  Lock lock(mutex_);
  charge_running();
  account.turn_seconds_ = 0;
  TurnClient& client = *account.client_;
  client.used_ = std::max(client.used_, virtual_time_);
  account.used_ = std::max(account.used_, client.virtual_time_);
  await(lock, account, cancelled);
  return {this, &account};
}

void Turns::await(Lock& lock, TurnAccount& account, const std::function<bool()>& cancelled) {
  TurnWaiter waiter{&account, account.used_, arrivals_++, {}};
  join(waiter);
  while (next() != &waiter) {
    waiter.woken.wait_for(lock, poll_of(waiting_));
    charge_running();
    if (!cancelled || !cancelled()) continue;
    leave(waiter);
    wake_next();
    throw Cancelled();
  }
  leave(waiter);
  begin(account);
  wake_next();
}

void Turns::join(TurnWaiter& waiter) {
  TurnClient& client = *waiter.account->client_;
  if (client.waiting_.empty()) waiting_clients_.push_back(&client);
  client.waiting_.insert(&waiter);
  ++waiting_;
}

void Turns::leave(TurnWaiter& waiter) {
  TurnClient& client = *waiter.account->client_;
  client.waiting_.erase(&waiter);
  if (client.waiting_.empty()) std::erase(waiting_clients_, &client);
  --waiting_;
}

void Turns::begin(TurnAccount& account) {
  --free_;
  ++account.client_->running_;
  running_.push_back(&account);
  account.charged_until_ = options_.now();
  begin_quantum(account);
}

void Turns::end(TurnAccount& account) {
  charge_running();
  std::erase(running_, &account);
  --account.client_->running_;
  ++free_;
  wake_next();
}

void Turns::begin_quantum(TurnAccount& account) {
  TurnClient& client = *account.client_;
  account.quantum_begin_ = account.charged_until_;
  virtual_time_ = std::max(virtual_time_, client.used_);
  client.virtual_time_ = std::max(client.virtual_time_, account.used_);
}

void Turns::charge_running() {
  const auto now = options_.now();
  double work = 0;
  for (TurnAccount* account : running_) {
    const double seconds = seconds_between(account->charged_until_, now);
    work += seconds;
    account->used_ += seconds;
    account->turn_seconds_ += seconds;
    account->client_->used_ += seconds;
    account->charged_until_ = now;
  }
  load_.add(work, now);
}

double Turns::load() {
  const std::lock_guard lock(mutex_);
  charge_running();
  return load_.now();
}

double Turns::busy_seconds() {
  const std::lock_guard lock(mutex_);
  charge_running();
  return load_.total();
}

size_t Turns::waiting() {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

bool Turns::may_run(const TurnClient& client) const {
  if (!options_.reserves_one || options_.concurrent == 1) return true;
  return client.running_ + 1 < options_.concurrent || live_clients() < 2;
}

unsigned Turns::live_clients() const {
  return static_cast<unsigned>(
      std::ranges::count_if(clients_, [](const auto& known) { return !known.second.expired(); }));
}

// Ties go to the earliest waiter.
TurnWaiter* Turns::next() const {
  if (free_ == 0) return nullptr;
  const auto rank = [](const TurnClient& client) {
    return std::pair(client.used_, (*client.waiting_.begin())->arrival);
  };
  const TurnClient* best = nullptr;
  for (const TurnClient* client : waiting_clients_)
    if ((!best || rank(*client) < rank(*best)) && may_run(*client)) best = client;
  return best ? *best->waiting_.begin() : nullptr;
}

void Turns::wake_next() {
  if (TurnWaiter* waiter = next()) waiter->woken.notify_one();
}

// The scenes of one client do not yield to each other: that would only delay all its frames.
bool Turns::should_yield(const TurnAccount& account) const {
  return free_ == 0 && std::ranges::any_of(waiting_clients_, [&](const TurnClient* other) {
           return other != account.client_.get() && other->used_ < account.client_->used_;
         });
}

}  // namespace collided::server
