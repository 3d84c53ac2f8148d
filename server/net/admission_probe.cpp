// Checks whether new clients can connect.
#include "server/net/admission_probe.hpp"

#include <netinet/in.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

#include "server/net/sockets/fd.hpp"

namespace collided::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kPeriod{250}, kProbePeriod{5'000};
constexpr milliseconds kTimeout{5'000};  // for one attempt: a host may be busy
constexpr int kTries = 3;                // a full table may evict a probe, too

struct Failure {
  std::string what;
};

/// How long an attempt may wait.
struct Wait {
  steady_clock::time_point deadline;
  const std::function<bool()>& should_stop;
};

[[noreturn]] void fail(const std::string& what, int error) { throw Failure{what + ": " + std::strerror(error)}; }

void wait_for(int socket, short events, const Wait& wait) {
  for (milliseconds left{1}; left.count() > 0 && !wait.should_stop();) {
    left = std::chrono::ceil<milliseconds>(wait.deadline - steady_clock::now());
    pollfd state{socket, events, 0};
    if (poll(&state, 1, static_cast<int>(std::clamp(left, milliseconds(0), kPeriod).count())) > 0) return;
  }
  throw Failure{"no answer on a new connection"};
}

// The address at which a listening socket is reached: by loopback if it listens on all addresses.
socklen_t address_of(int listening, sockaddr_storage& address) {
  socklen_t size = sizeof(address);
  if (getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size) != 0) fail("getsockname", errno);
  auto& v4 = reinterpret_cast<sockaddr_in&>(address);
  auto& v6 = reinterpret_cast<sockaddr_in6&>(address);
  if (address.ss_family == AF_INET && v4.sin_addr.s_addr == INADDR_ANY) v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (address.ss_family == AF_INET6 && IN6_IS_ADDR_UNSPECIFIED(&v6.sin6_addr)) v6.sin6_addr = in6addr_loopback;
  return size;
}

Fd connect_to(int listening, const Wait& wait) {
  sockaddr_storage address{};
  const socklen_t size = address_of(listening, address);
  Fd socket(::socket(address.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) fail("no socket for a new connection", errno);
  if (connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), size) == 0) return socket;
  if (errno != EINPROGRESS) fail("connecting", errno);
  wait_for(socket.get(), POLLOUT, wait);
  int error = 0;
  socklen_t error_size = sizeof(error);
  getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &error_size);
  if (error != 0) fail("connecting", error);
  return socket;
}

// The preface with empty SETTINGS.
std::string http2_greeting() {
  using std::string_view_literals::operator""sv;
  return std::string("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0"sv);
}

// A ClientHello.
std::string tls_greeting() {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  const std::unique_ptr<SSL, decltype(&SSL_free)> tls(context ? SSL_new(context.get()) : nullptr, SSL_free);
  if (!tls) throw Failure{"OpenSSL cannot create a client"};
  constexpr unsigned char kProtocols[] = {2, 'h', '2'};
  SSL_set_alpn_protos(tls.get(), kProtocols, sizeof(kProtocols));
  BIO* const out = BIO_new(BIO_s_mem());
  SSL_set_bio(tls.get(), BIO_new(BIO_s_mem()), out);
  SSL_connect(tls.get());  // has written its ClientHello, and waits for the answer
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(out, &bytes);
  return {bytes, static_cast<size_t>(size)};
}

// The type of the first frame or record suffices.
void expect_answer(int socket, bool is_tls, const Wait& wait) {
  constexpr size_t kHead = 5;
  constexpr char kSettings = 4, kHandshake = 22;
  char head[kHead] = {};
  for (size_t size = 0; size < kHead;) {
    wait_for(socket, POLLIN, wait);
    const ssize_t got = recv(socket, head + size, kHead - size, 0);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (got < 0) fail("a new connection was closed", errno);
    if (got == 0) throw Failure{"a new connection was closed at once"};
    size += static_cast<size_t>(got);
  }
  if (is_tls ? head[0] != kHandshake : head[3] != kSettings)
    throw Failure{is_tls ? "a TLS handshake was refused" : "an unexpected answer on a new connection"};
}

}  // namespace

std::string probe(const ProbeTarget& target, const std::function<bool()>& should_stop) try {
  const Wait wait{steady_clock::now() + kTimeout, should_stop};
  const Fd socket = connect_to(target.socket, wait);
  const std::string greeting = target.is_tls ? tls_greeting() : http2_greeting();
  if (send(socket.get(), greeting.data(), greeting.size(), MSG_NOSIGNAL) < 0)
    fail("a new connection accepts no data", errno);
  expect_answer(socket.get(), target.is_tls, wait);
  return {};
} catch (const Failure& failure) {
  return failure.what;
}

AdmissionProbe::AdmissionProbe(std::vector<ProbeTarget> targets, std::function<std::string()> shortage,
                               std::function<void(const std::string&)> report)
    : targets_(std::move(targets)),
      shortage_(std::move(shortage)),
      report_(std::move(report)),
      thread_([this] { run(); }) {}

AdmissionProbe::~AdmissionProbe() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  stopping_.notify_all();
  thread_.join();
}

void AdmissionProbe::run() {
  do {
    const std::string now = check();
    if (!is_stopping_ && now != reported_) report_(reported_ = now);
  } while (wait(kPeriod));
}

// Probes periodically, and continuously while something is wrong. A shortage that arises meanwhile explains what the
// probe saw.
std::string AdmissionProbe::check() {
  if (auto shortage = shortage_(); !shortage.empty()) return shortage;
  if (reported_.empty() && steady_clock::now() < next_) return {};
  auto obstacle = probe_all();
  next_ = steady_clock::now() + kProbePeriod;
  auto shortage = shortage_();
  return shortage.empty() ? obstacle : shortage;
}

std::string AdmissionProbe::probe_all() const {
  for (const ProbeTarget& target : targets_) {
    std::string what;
    for (int tries = 0; tries < kTries && !(what = probe(target, [this] { return should_stop(); })).empty(); ++tries)
      continue;
    if (!what.empty()) return "new clients cannot connect to " + target.address + ": " + what;
  }
  return {};
}

// False once the probe is to end.
bool AdmissionProbe::wait(milliseconds time) {
  std::unique_lock lock(mutex_);
  return !stopping_.wait_for(lock, time, [this] { return is_stopping_.load(); });
}

}  // namespace collided::server
