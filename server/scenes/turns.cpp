// Fair turns on a shared device: start-time fair queuing, a quantum at a time.
#include "server/scenes/turns.hpp"

#include <algorithm>
#include <utility>

#include "gpu/detector.hpp"

namespace collided::server {
namespace {

constexpr auto kLookForCancel = std::chrono::milliseconds(10);

}  // namespace

Turns::Turn::~Turn() {
  if (turns_ == nullptr) return;
  const std::lock_guard lock(turns_->mutex_);
  turns_->end(*account_);
}

double Turns::Turn::seconds() const {
  const std::lock_guard lock(turns_->mutex_);
  turns_->charge_running();
  return account_->of_turn_;
}

void Turns::Turn::give_way(const std::function<bool()>& cancelled) {
  Lock lock(turns_->mutex_);
  turns_->charge_running();
  if (account_->charged_ - account_->resumed_ < kQuantum) return;
  turns_->begin_quantum(*account_);
  if (!turns_->should_give_way(*account_)) return;
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
  account.of_turn_ = 0;
  TurnClient& client = *account.client_;
  client.used_ = std::max(client.used_, now_);
  account.used_ = std::max(account.used_, client.now_);
  await(lock, account, cancelled);
  return {this, &account};
}

void Turns::await(Lock& lock, TurnAccount& account, const std::function<bool()>& cancelled) {
  Waiter waiter{&account, {}};
  const auto place = waiting_.insert(waiting_.end(), &waiter);
  while (next() != &waiter) {
    waiter.called.wait_for(lock, kLookForCancel);
    charge_running();
    if (!cancelled || !cancelled()) continue;
    waiting_.erase(place);
    call_next();
    throw Cancelled();
  }
  waiting_.erase(place);
  begin(account);
  call_next();
}

void Turns::begin(TurnAccount& account) {
  --free_;
  ++account.client_->running_;
  running_.push_back(&account);
  account.charged_ = options_.now();
  begin_quantum(account);
}

void Turns::end(TurnAccount& account) {
  charge_running();
  std::erase(running_, &account);
  --account.client_->running_;
  ++free_;
  call_next();
}

void Turns::begin_quantum(TurnAccount& account) {
  TurnClient& client = *account.client_;
  account.resumed_ = account.charged_;
  now_ = std::max(now_, client.used_);
  client.now_ = std::max(client.now_, account.used_);
}

void Turns::charge_running() {
  const auto now = options_.now();
  for (TurnAccount* account : running_) {
    const double seconds = seconds_between(account->charged_, now);
    account->used_ += seconds;
    account->of_turn_ += seconds;
    account->client_->used_ += seconds;
    account->charged_ = now;
  }
}

bool Turns::may_run(const TurnClient& client) const {
  if (!options_.keeps_one_free || options_.at_once == 1) return true;
  return client.running_ + 1 < options_.at_once || live_clients() < 2;
}

unsigned Turns::live_clients() const {
  return static_cast<unsigned>(
      std::ranges::count_if(clients_, [](const auto& known) { return !known.second.expired(); }));
}

// Of equals, the one that came first.
Turns::Waiter* Turns::next() const {
  if (free_ == 0) return nullptr;
  Waiter* best = nullptr;
  for (Waiter* waiter : waiting_) {
    const TurnAccount& account = *waiter->account;
    if (!may_run(*account.client_)) continue;
    const bool is_same_client = best && best->account->client_ == account.client_;
    if (!best || (is_same_client ? account.used_ < best->account->used_
                                 : account.client_->used_ < best->account->client_->used_))
      best = waiter;
  }
  return best;
}

void Turns::call_next() {
  if (Waiter* waiter = next()) waiter->called.notify_one();
}

// Within a client nobody gives way: its frames would all be done later.
bool Turns::should_give_way(const TurnAccount& account) const {
  return free_ == 0 && std::ranges::any_of(waiting_, [&](const Waiter* waiter) {
           const TurnClient& other = *waiter->account->client_;
           return &other != account.client_.get() && other.used_ < account.client_->used_;
         });
}

}  // namespace collided::server
