// Closes descriptors that clients have sent, on threads that nobody waits for.
#include "server/transport/local/disposal.hpp"

#include <linux/magic.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/vfs.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace collided::server {
namespace {

// Never destroyed: a blocked thread may outlive main.
struct Disposal {
  std::mutex mutex;
  std::condition_variable more;
  std::deque<Fd> waiting;  // guarded by mutex, as the others
  size_t threads = 0, idle = 0, closing = 0;
};

constexpr size_t kMaxThreads = 8;  // and so of files that may block at once
constexpr auto kIdle = std::chrono::seconds(1);

Disposal& disposal() {
  static Disposal& one = *new Disposal;
  return one;
}

// Unread packets of a socket may contain files, too. On other descriptors recv() fails.
void close_now(Fd fd) {
  char byte;
  while (recv(fd.get(), &byte, 1, MSG_DONTWAIT) > 0) continue;
}

void run() {
  Disposal& own = disposal();
  std::unique_lock lock(own.mutex);
  for (;;) {
    ++own.idle;
    const bool found = own.more.wait_for(lock, kIdle, [&] { return !own.waiting.empty(); });
    --own.idle;
    if (!found) break;
    Fd fd = std::move(own.waiting.front());
    own.waiting.pop_front();
    lock.unlock();
    close_now(std::move(fd));
    lock.lock();
    --own.closing;
  }
  --own.threads;
}

void begin_thread_locked(Disposal& own) {
  try {
    std::thread(run).detach();
    ++own.threads;
  } catch (const std::system_error&) {  // another thread will close it
  }
}

}  // namespace

void close_in_background(Fd fd) {
  if (!fd) return;
  Disposal& own = disposal();
  const std::lock_guard lock(own.mutex);
  own.waiting.push_back(std::move(fd));
  ++own.closing;
  if (own.idle < own.waiting.size() && own.threads < kMaxThreads) begin_thread_locked(own);
  own.more.notify_one();
}

size_t closing() {
  Disposal& own = disposal();
  const std::lock_guard lock(own.mutex);
  return own.closing;
}

bool is_memory(int fd) {
  struct stat file {};
  struct statfs system {};
  return fstat(fd, &file) == 0 && S_ISREG(file.st_mode) && fstatfs(fd, &system) == 0 && system.f_type == TMPFS_MAGIC;
}

PassedFile& PassedFile::operator=(PassedFile&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

PassedFile::~PassedFile() {
  if (fd_ && !is_memory(fd_.get())) close_in_background(std::move(fd_));
}

}  // namespace collided::server
