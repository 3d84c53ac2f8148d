#pragma once
// A thread for each shard of a scene; the first shard's is the caller's own.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace collided {

class Crew {
 public:
  /// Throws std::system_error where the host is short of threads.
  explicit Crew(size_t size) {
    try {
      for (size_t k = 1; k < size; ++k) threads_.emplace_back([this, k] { live(k); });
    } catch (...) {
      end();
      throw;
    }
  }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  ~Crew() { end(); }

  /// work(k) on thread k, for all of them; returns when all are done. It throws nothing.
  void run(const std::function<void(size_t)>& work) {
    {
      const std::lock_guard lock(mutex_);
      work_ = &work;
      left_ = threads_.size();
      ++round_;
    }
    changed_.notify_all();
    work(0);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return left_ == 0; });
  }

 private:
  void end() {
    {
      const std::lock_guard lock(mutex_);
      is_over_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  void live(size_t k) {
    std::unique_lock lock(mutex_);
    for (uint64_t done = 0;;) {
      changed_.wait(lock, [&] { return is_over_ || round_ != done; });
      if (is_over_) return;
      done = round_;
      const std::function<void(size_t)>& work = *work_;
      lock.unlock();
      work(k);
      lock.lock();
      if (--left_ == 0) changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void(size_t)>* work_ = nullptr;
  uint64_t round_ = 0;
  size_t left_ = 0;
  bool is_over_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace collided
