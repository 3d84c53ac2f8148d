// The Unix socket for clients on the daemon's host.
#include "server/transport/local/local_server.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "server/errors.hpp"
#include "server/net/sockets/peer.hpp"
#include "server/ops/log.hpp"

namespace collided::server {
namespace {

constexpr mode_t kOwnUser = 0600, kAnyUser = 0666;  // of the socket's file; the peer is checked as well
constexpr size_t kMaxClosing = 64;                  // descriptors: clients' files, and connections
constexpr int kRetryMs = 100;                       // while the process has no file descriptor left

// Without the memory to say why, the client is only hung up on.
void refuse(Fd socket, const Failure& why) try {
  log_event(spdlog::level::warn, "local connection refused", {{"code", code_name(why.code)}, {"reason", why.message}});
  send_packet(socket.get(), closed_packet(why));
  end_connection(std::move(socket));
} catch (const std::bad_alloc&) {
}

}  // namespace

LocalServer::LocalServer(const LocalOptions& options, SceneHost& host, const Authenticator& authenticator,
                         Metrics& metrics)
    : options_(options), metrics_(metrics), rules_{host, authenticator, options.cuda_ipc} {
  const mode_t mode = options.allowed_uids.empty() ? kOwnUser : kAnyUser;
  listener_ = std::make_unique<UnixListener>(options.path, UnixListener::Options{SOCK_SEQPACKET, mode});
  wake_ = Fd(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!wake_) throw std::system_error(errno, std::generic_category(), "eventfd");
  thread_ = std::thread([this] { run(); });
}

LocalServer::~LocalServer() { stop(); }

void LocalServer::stop() {
  if (is_stopping_.exchange(true)) return;
  wake();
  thread_.join();
  listener_.reset();
  const std::lock_guard lock(mutex_);
  for (auto& served : served_) served.connection->stop();
  for (auto& served : served_) served.thread.join();
  served_.clear();
}

void LocalServer::announce_stop() {
  const auto why = std::make_exception_ptr(Stopping());
  const std::lock_guard lock(mutex_);
  for (const Served& served : served_) served.connection->end_unopened(why);
}

void LocalServer::run() {
  pollfd states[] = {{listener_->socket(), POLLIN, 0}, {wake_.get(), POLLIN, 0}};
  while (!is_stopping_) {
    poll(states, 2, -1);
    eventfd_t count = 0;
    eventfd_read(wake_.get(), &count);
    join_ended();
    take_connections();
  }
}

void LocalServer::take_connections() {
  while (Fd socket = listener_->accept()) {
    try {
      check_peer(socket.get());
      rules_.host.check_serving();
      check_connections();
    } catch (...) {
      refuse(std::move(socket), describe_current());
      continue;
    }
    serve(std::move(socket));
  }
  pollfd state{wake_.get(), POLLIN, 0};
  if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS) poll(&state, 1, kRetryMs);
}

void LocalServer::check_peer(int socket) const {
  const uid_t uid = peer_uid(socket);
  const auto& allowed = options_.allowed_uids;
  if (uid == geteuid() || std::find(allowed.begin(), allowed.end(), uid) != allowed.end()) return;
  throw PermissionDenied(
      "", fmt::format("user {} may not use {}: it is neither the daemon's own nor in --allow-uid", uid, options_.path));
}

// Of those that have opened no stream, the one that has waited longest: honest clients open at once.
bool LocalServer::evict_silent() {
  const auto why = std::make_exception_ptr(LimitExceeded::quota(
      "daemon", fmt::format("max_streams is {}, and as many connections are open on {}; of those without a stream "
                            "this one has waited longest",
                            rules_.host.limits().max_streams, options_.path)));
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(served_, [&](const Served& served) { return served.connection->end_unopened(why); });
}

// Those that were evicted take a moment to end.
void LocalServer::check_connections() {
  const size_t max = rules_.host.limits().max_streams, open = connections();
  if (open >= 2 * max || (open >= max && !evict_silent()))
    throw LimitExceeded::quota(
        "daemon", fmt::format("max_streams is {}, and {} connections are open on {}", max, open, options_.path));
  if (closing() > kMaxClosing)
    throw LimitExceeded::quota(
        "daemon", fmt::format("{} files that clients sent over {} are still being closed", closing(), options_.path));
}

// Whatever the process is short of, the client is told, and others are still accepted.
void LocalServer::serve(Fd socket) {
  std::shared_ptr<Connection> connection;
  try {
    connection = std::make_shared<Connection>(std::move(socket), rules_, metrics_, options_.timeouts);
    begin_thread(connection);
  } catch (...) {
    refuse(connection ? connection->release_socket() : std::move(socket), describe_current());
  }
}

void LocalServer::begin_thread(const std::shared_ptr<Connection>& connection) {
  const std::lock_guard lock(mutex_);
  Served& served = served_.emplace_back();
  served.connection = connection;
  try {
    served.thread = std::thread([this, &served] {
      served.connection->serve();
      served.is_over = true;
      wake();
    });
  } catch (...) {
    served_.pop_back();
    throw;
  }
}

void LocalServer::join_ended() {
  std::list<Served> ended;
  {
    const std::lock_guard lock(mutex_);
    for (auto next = served_.begin(); next != served_.end();) {
      const auto served = next++;
      if (served->is_over) ended.splice(ended.end(), served_, served);
    }
  }
  for (auto& served : ended) served.thread.join();
}

size_t LocalServer::connections() const {
  const std::lock_guard lock(mutex_);
  return served_.size();
}

uint64_t LocalServer::outgoing_bytes() const {
  uint64_t bytes = 0;
  const std::lock_guard lock(mutex_);
  for (const auto& served : served_) bytes += served.connection->outgoing_bytes();
  return bytes;
}

void LocalServer::wake() const { eventfd_write(wake_.get(), 1); }

}  // namespace collided::server
