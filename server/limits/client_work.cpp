// Work on the host for calls of clients.
#include "server/limits/client_work.hpp"

#include <optional>
#include <utility>

namespace collided::server {

struct ClientWork::Task {
  TurnAccount account;
  Job job;
  std::optional<Turns::Turn> turn;  // ends before the account
};

ClientWork::ClientWork(Turns& turns) : turns_(turns) {
  for (unsigned i = 0; i < turns.concurrent(); ++i) threads_.emplace_back([this] { run(); });
}

ClientWork::~ClientWork() {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return size_ == 0; });
    is_over_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void ClientWork::post(const TurnPath& client, Job job) {
  auto task = std::make_unique<Task>(turns_.account(client), std::move(job), std::nullopt);
  TurnAccount& account = task->account;
  {
    const std::lock_guard lock(mutex_);
    ++size_;
  }
  turns_.request(account, [this, waiting = task.release()](Turns::Turn turn) {
    waiting->turn.emplace(std::move(turn));
    const std::lock_guard lock(mutex_);
    granted_.emplace_back(waiting);
    changed_.notify_one();
  });
}

size_t ClientWork::size() const {
  const std::lock_guard lock(mutex_);
  return size_;
}

void ClientWork::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return is_over_ || !granted_.empty(); });
    if (granted_.empty()) return;
    auto task = std::move(granted_.front());
    granted_.pop_front();
    lock.unlock();
    task->job();
    task.reset();
    lock.lock();
    if (--size_ == 0) changed_.notify_all();
  }
}

}  // namespace collided::server
