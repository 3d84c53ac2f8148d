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
    changed_.wait(lock, [this] { return is_idle(); });
    is_over_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void ClientWork::post(const TurnPath& client, Job job) {
  Tasks posted;
  posted.emplace_back(turns_.account(client), std::move(job), std::nullopt);
  const auto task = posted.begin();
  {
    const std::lock_guard lock(mutex_);
    waiting_.splice(waiting_.end(), posted);
  }
  try {
    turns_.request(task->account, [this, task](Turns::Turn turn) {  // moves the task only: it cannot run out of memory
      task->turn.emplace(std::move(turn));
      const std::lock_guard lock(mutex_);
      granted_.splice(granted_.end(), waiting_, task);
      changed_.notify_one();
    });
  } catch (...) {
    const std::lock_guard lock(mutex_);
    posted.splice(posted.end(), waiting_, task);
    if (is_idle()) changed_.notify_all();
    throw;
  }
}

size_t ClientWork::size() const {
  const std::lock_guard lock(mutex_);
  return waiting_.size() + granted_.size() + running_;
}

bool ClientWork::is_idle() const { return waiting_.empty() && granted_.empty() && running_ == 0; }

void ClientWork::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return is_over_ || !granted_.empty(); });
    if (granted_.empty()) return;
    Tasks task;
    task.splice(task.end(), granted_, granted_.begin());
    ++running_;
    lock.unlock();
    task.front().job();
    task.clear();
    lock.lock();
    --running_;
    if (is_idle()) changed_.notify_all();
  }
}

}  // namespace collided::server
