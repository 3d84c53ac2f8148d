// Decides who works next by start-time fair queuing on a tree, a quantum at a time.
#include "server/devices/turns.hpp"

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

/// Afterwards `more` items can be added without allocating.
template <class Item>
void make_room(std::vector<Item>& items, size_t more) {
  const size_t needed = items.size() + more;
  if (items.capacity() < needed) items.reserve(std::max(needed, 2 * items.size()));
}

}  // namespace

Turns::Turns(Options options) : options_(std::move(options)), free_(options_.concurrent), load_(options_.now()) {
  running_.reserve(options_.concurrent);
}

// use(share, the one above it), up to the root.
template <class Use>
void Turns::for_each_up(TurnShare& from, const Use& use) {
  for (TurnShare* share = &from; share != &root_;) {
    TurnShare& parent = above(*share);
    use(*share, parent);
    share = &parent;
  }
}

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

TurnAccount Turns::account(const TurnPath& client) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<TurnShare> parent;
  for (const std::string& name : client) parent = group(parent, name);
  if (!parent) return {};
  return TurnAccount(std::move(parent));
}

std::shared_ptr<TurnShare> Turns::group(const std::shared_ptr<TurnShare>& parent, const std::string& name) {
  auto& groups = (parent ? *parent : root_).groups_;
  const auto found = groups.find(name);
  if (found != groups.end())
    if (auto alive = found->second.lock()) return alive;
  forget_debts();
  std::erase_if(groups, [](const auto& known) { return known.second.expired(); });
  std::shared_ptr<TurnShare> made(new TurnShare(parent));
  groups[name] = made;
  return made;
}

Turns::Turn Turns::take(TurnAccount& account, const std::function<bool()>& cancelled) {
  Lock lock(mutex_);
  prepare(account);
  await(lock, account, cancelled);
  return {this, &account};
}

void Turns::request(TurnAccount& account, std::function<void(Turn)> granted) {
  const std::lock_guard lock(mutex_);
  prepare(account);
  join(account, [this, &account, granted = std::move(granted)] { granted(Turn(this, &account)); });
  grant();
}

void Turns::prepare(TurnAccount& account) {
  charge_running();
  account.turn_seconds_ = 0;
  for_each_up(account,
              [](TurnShare& share, TurnShare& above) { share.used_ = std::max(share.used_, above.virtual_time_); });
}

void Turns::await(Lock& lock, TurnAccount& account, const std::function<bool()>& cancelled) {
  std::condition_variable woken;
  bool is_granted = false;
  join(account, [&] {
    is_granted = true;
    woken.notify_one();
  });
  grant();
  while (!is_granted) {
    woken.wait_for(lock, poll_of(waiting_));
    charge_running();
    if (is_granted || !cancelled || !cancelled()) continue;
    leave(account);
    grant();
    throw Cancelled();
  }
}

// A turn allocates here all that it needs later, for only here can the caller be told that memory is short. Once it has
// been granted it reaches its owner, and it ends.
void Turns::join(TurnAccount& account, std::function<void()> granted) {
  for_each_up(account, [](TurnShare&, TurnShare& above) { make_room(above.waiting_, 1); });
  make_room(debtors_, waiting_ + running_.size() + 1);
  account.granted_ = std::move(granted);
  account.account_ = &account;
  const uint64_t arrival = arrivals_++;
  for_each_up(account, [&](TurnShare& share, TurnShare& above) {
    if (std::ranges::find(above.waiting_, &share) != above.waiting_.end()) return;
    share.arrival_ = arrival;
    above.waiting_.push_back(&share);
  });
  ++waiting_;
}

void Turns::leave(TurnAccount& account) {
  account.account_ = nullptr;
  for_each_up(account, [](TurnShare& share, TurnShare& above) {
    const auto arrival = [](const TurnShare* child) { return child->arrival_; };
    if (share.account_ == nullptr && share.waiting_.empty())
      std::erase(above.waiting_, &share);
    else
      share.arrival_ = std::ranges::min(share.waiting_, {}, arrival)->arrival_;
  });
  --waiting_;
}

// The turn begins here, even if the waiting thread wakes up later.
void Turns::grant() {
  while (free_ > 0) {
    TurnAccount* const account = next_of(root_);
    if (account == nullptr) return;
    leave(*account);
    begin(*account);
    std::exchange(account->granted_, {})();
  }
}

void Turns::begin(TurnAccount& account) {
  --free_;
  for_each_up(account, [](TurnShare& share, TurnShare&) { ++share.running_; });
  running_.push_back(&account);
  account.charged_until_ = options_.now();
  begin_quantum(account);
}

void Turns::end(TurnAccount& account) {
  charge_running();
  std::erase(running_, &account);
  for_each_up(account, [](TurnShare& share, TurnShare&) { --share.running_; });
  ++free_;
  keep_debt(account);
  grant();
}

// Without this a client that asks repeatedly, and holds nothing in between, would start at zero each time.
void Turns::keep_debt(const TurnAccount& account) {
  const std::shared_ptr<TurnShare>& client = account.parent_;
  if (client->used_ <= above(*client).virtual_time_) return;
  if (std::ranges::find(debtors_, client) == debtors_.end()) debtors_.push_back(client);
}

void Turns::forget_debts() {
  std::erase_if(debtors_, [this](const auto& client) { return client->used_ <= above(*client).virtual_time_; });
}

void Turns::begin_quantum(TurnAccount& account) {
  account.quantum_begin_ = account.charged_until_;
  for_each_up(account, [](const TurnShare& share, TurnShare& above) {
    above.virtual_time_ = std::max(above.virtual_time_, share.used_);
  });
}

void Turns::charge_running() {
  const auto now = options_.now();
  double work = 0;
  for (TurnAccount* account : running_) {
    const double seconds = seconds_between(account->charged_until_, now);
    work += seconds;
    for_each_up(*account, [&](TurnShare& share, TurnShare&) { share.used_ += seconds; });
    account->turn_seconds_ += seconds;
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

// A group leaves one turn to its siblings while it has any.
bool Turns::may_run(const TurnShare& share, const TurnShare& above) const {
  if (!options_.reserves_one || options_.concurrent == 1 || share.account_ != nullptr) return true;
  if (share.running_ + 1 < options_.concurrent) return true;
  unsigned live = 0;
  return std::ranges::none_of(above.groups_, [&](const auto& known) { return !known.second.expired() && ++live == 2; });
}

bool Turns::has_next(const TurnShare& share, const TurnShare& above) const {
  if (!options_.reserves_one || share.account_ != nullptr) return true;
  return may_run(share, above) &&
         std::ranges::any_of(share.waiting_, [&](const TurnShare* child) { return has_next(*child, share); });
}

// Ties go to the earliest waiter.
TurnAccount* Turns::next_of(const TurnShare& share) const {
  if (share.account_ != nullptr) return share.account_;
  const auto rank = [](const TurnShare& child) { return std::pair(child.used_, child.arrival_); };
  const TurnShare* best = nullptr;
  for (const TurnShare* child : share.waiting_)
    if ((!best || rank(*child) < rank(*best)) && has_next(*child, share)) best = child;
  return best ? next_of(*best) : nullptr;
}

// The scenes of one client do not yield to each other: that would only delay all its frames.
bool Turns::should_yield(const TurnAccount& account) {
  if (free_ > 0) return false;
  bool is_behind = false;  // another group has used less than the one of this turn
  for_each_up(above(account), [&](const TurnShare& share, const TurnShare& above) {
    is_behind = is_behind || std::ranges::any_of(above.waiting_, [&](const TurnShare* other) {
                  return other != &share && other->used_ < share.used_;
                });
  });
  return is_behind;
}

}  // namespace collided::server
