// Accepts connections on its own thread and hands them on.
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
constexpr int kRetryMs = 50;  // while the process has no descriptor left
constexpr int kFullMs = 2;    // while evicted connections are being closed
constexpr int kBatch = 64;    // connections from one socket before the next socket is served

// accept4() takes a descriptor before it checks whether a connection is waiting.
bool has_waiting(int socket) {
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

std::string AcceptLoop::shortage() const {
  const std::lock_guard lock(mutex_);
  return shortage_;
}

void AcceptLoop::run() {
  std::vector<pollfd> states;
  for (const int socket : sockets_) states.push_back({socket, POLLIN, 0});
  states.push_back({wake_.get(), POLLIN, 0});
  while (!is_stopping_) {
    const bool is_short = !shortage().empty(), is_full = !connections_.may_accept();
    // While nothing can be accepted the sockets stay readable, so wait only for the stop.
    if (is_short || is_full)
      poll(&states.back(), 1, is_short ? kRetryMs : kFullMs);
    else
      poll(states.data(), states.size(), -1);
    for (size_t i = 0; i < sockets_.size() && !is_stopping_; ++i)
      if (is_short || is_full || states[i].revents) accept_batch(i);
  }
}

void AcceptLoop::accept_batch(size_t place) {
  for (int taken = 0; taken < kBatch; ++taken) {
    if (!connections_.may_accept()) return;
    Fd connection(accept4(sockets_[place], nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    const int error = connection ? 0 : errno;
    if (error == EAGAIN || (is_shortage(error) && !has_waiting(sockets_[place]))) return on_recovery();
    if (is_shortage(error)) return on_shortage(error);
    if (!connection) continue;  // the client has already given up
    if (connections_.admit(connection.get(), peer_of(connection.get()))) take_(std::move(connection), place);
  }
}

// The reserve serves the clients that wait now; evicted connections replenish it.
void AcceptLoop::on_shortage(int error) {
  reserve_.clear();
  connections_.evict(kReserve);
  const std::lock_guard lock(mutex_);
  if (!shortage_.empty()) return;
  shortage_ = std::string("cannot accept connections: ") + std::strerror(error);
  spdlog::error("{}; ending connections that made no call", shortage_);
}

// The backlog is empty, and a descriptor was free for the next connection.
void AcceptLoop::on_recovery() {
  fill_reserve();
  const std::lock_guard lock(mutex_);
  if (shortage_.empty() || reserve_.size() < kReserve) return;
  shortage_.clear();
  spdlog::info("accepting connections again");
}

void AcceptLoop::fill_reserve() {
  while (reserve_.size() < kReserve) {
    Fd spare(open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (!spare) return;
    reserve_.push_back(std::move(spare));
  }
}

}  // namespace collided::server
