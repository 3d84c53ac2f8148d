// Accepts connections on its own thread and hands them on.
#include "server/net/accept_loop.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace collided::server {
namespace {

constexpr size_t kReserve = 16;
constexpr int kRetryMs = 50;   // while the process has no descriptor left
constexpr int kFullMs = 2;     // while evicted connections are being closed
constexpr int kTurnMs = 2;     // while connections wait for their turn
constexpr int kCheckMs = 500;  // between two searches for connections without a call
constexpr int kBatch = 64;     // connections from one socket before the next socket is served
constexpr size_t kMinUnread = 2;

// accept4() takes a descriptor before it checks whether a connection is waiting.
bool has_waiting(int socket) {
  pollfd state{socket, POLLIN, 0};
  return poll(&state, 1, 0) != 0;
}

bool is_shortage(int error) { return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM; }

}  // namespace

AcceptLoop::AcceptLoop(std::vector<int> sockets, Connections& connections, Take take, MayTake may_take)
    : sockets_(std::move(sockets)),
      connections_(connections),
      take_(std::move(take)),
      may_take_(std::move(may_take)),
      waiting_(std::max<size_t>(kMinUnread, std::thread::hardware_concurrency())),
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
  while (!is_stopping_) look();
}

void AcceptLoop::look() {
  const bool is_short = !shortage().empty(), is_full = !connections_.may_accept();
  std::vector<pollfd> states;
  // While nothing can be accepted the sockets stay readable, so they are left out (poll() ignores -1).
  for (const int socket : sockets_) states.push_back({is_short || is_full ? -1 : socket, POLLIN, 0});
  states.push_back({wake_.get(), POLLIN, 0});
  waiting_.watch(states);
  poll(states.data(), states.size(), patience_ms(is_short, is_full));
  waiting_.update(&states[sockets_.size() + 1]);
  for (size_t i = 0; i < sockets_.size() && !is_stopping_; ++i)
    if (is_short || is_full || states[i].revents) accept_batch(i);
  if (!may_take_) return;
  hand_over();
  end_callless();
}

int AcceptLoop::patience_ms(bool is_short, bool is_full) const {
  if (is_full) return kFullMs;
  if (waiting_.ready() > 0) return kTurnMs;
  if (is_short) return kRetryMs;
  return may_take_ && connections_.size() > 0 ? kCheckMs : -1;
}

void AcceptLoop::accept_batch(size_t place) {
  for (int taken = 0; taken < kBatch; ++taken) {
    if (!connections_.may_accept()) return;
    Fd connection(accept4(sockets_[place], nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    const int error = connection ? 0 : errno;
    if (error == EAGAIN || (is_shortage(error) && !has_waiting(sockets_[place]))) return on_recovery();
    if (is_shortage(error)) return on_shortage(error);
    if (!connection) continue;  // the client has already given up
    if (may_take_ && has_left(connection.get())) continue;
    Peer peer = peer_of(connection.get());
    connections_.admit(connection.get(), peer);
    if (may_take_)
      waiting_.add({std::move(connection), place, std::move(peer.source)});
    else
      take_(std::move(connection), place);
  }
}

void AcceptLoop::hand_over() {
  while (!is_stopping_ && may_take_()) {
    WaitingConnections::Connection next = waiting_.next();
    if (!next.fd) return;
    connections_.handed_over(next.fd.get());
    take_(std::move(next.fd), next.place);
  }
}

void AcceptLoop::end_callless() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_check_) return;
  next_check_ = now + std::chrono::milliseconds(kCheckMs);
  for (const EndedConnection& ended : connections_.end_callless(now))
    spdlog::warn("connection of {} ended: {}", ended.peer, ended.why);
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
