// Accepts connections, on a thread of its own, and hands them on.
#include "server/net/accept_loop.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace collided::server {
namespace {

constexpr size_t kReserve = 16;
constexpr int kRetryMs = 50;  // where the process has no descriptor left
constexpr int kFullMs = 2;    // until connections that were ended are closed
constexpr int kBatch = 64;    // connections of one socket before the next socket has its turn

// accept4() wants a descriptor before it looks whether anybody waits.
bool is_awaited(int socket) {
  pollfd state{socket, POLLIN, 0};
  return poll(&state, 1, 0) != 0;
}

bool is_shortage(int error) { return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM; }

}  // namespace

AcceptLoop::AcceptLoop(std::vector<int> sockets, Connections& connections, Take take)
    : sockets_(std::move(sockets)),
      connections_(connections),
      take_(std::move(take)),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!wake_) throw std::system_error(errno, std::generic_category(), "eventfd");
  fill_reserve();
  thread_ = std::thread([this] { run(); });
}

void AcceptLoop::stop() {
  if (is_stopping_.exchange(true)) return;
  eventfd_write(wake_.get(), 1);
  thread_.join();
}

std::string AcceptLoop::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

void AcceptLoop::run() {
  std::vector<pollfd> states;
  for (const int socket : sockets_) states.push_back({socket, POLLIN, 0});
  states.push_back({wake_.get(), POLLIN, 0});
  while (!is_stopping_) {
    const bool is_short = !trouble().empty(), is_full = !connections_.may_accept();
    // Where none can be taken, the sockets stay readable: only being stopped is worth waking up for.
    if (is_short || is_full)
      poll(&states.back(), 1, is_short ? kRetryMs : kFullMs);
    else
      poll(states.data(), states.size(), -1);
    for (size_t i = 0; i < sockets_.size() && !is_stopping_; ++i)
      if (is_short || is_full || states[i].revents) take_some(i);
  }
}

void AcceptLoop::take_some(size_t place) {
  for (int taken = 0; taken < kBatch; ++taken) {
    if (!connections_.may_accept()) return;
    Fd connection(accept4(sockets_[place], nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    const int error = connection ? 0 : errno;
    if (error == EAGAIN || (is_shortage(error) && !is_awaited(sockets_[place]))) return end_trouble();
    if (is_shortage(error)) return begin_trouble(error);
    if (!connection) continue;  // one that is gone again
    if (connections_.admit(connection.get(), peer_of(connection.get()))) take_(std::move(connection), place);
  }
}

// The reserve serves whoever waits now; those that are ended make up for it.
void AcceptLoop::begin_trouble(int error) {
  reserve_.clear();
  connections_.end_some(kReserve);
  const std::lock_guard lock(mutex_);
  if (!trouble_.empty()) return;
  trouble_ = std::string("cannot accept connections: ") + std::strerror(error);
  spdlog::error("{}; those that made no call are ended", trouble_);
}

// Nobody waits any more, and a descriptor was there for whoever would.
void AcceptLoop::end_trouble() {
  fill_reserve();
  const std::lock_guard lock(mutex_);
  if (trouble_.empty() || reserve_.size() < kReserve) return;
  trouble_.clear();
  spdlog::info("connections are accepted again");
}

void AcceptLoop::fill_reserve() {
  while (reserve_.size() < kReserve) {
    Fd spare(open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (!spare) return;
    reserve_.push_back(std::move(spare));
  }
}

}  // namespace collided::server
