// Whether a new client gets in.
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

#include "server/net/fd.hpp"

namespace collided::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kPeriod{250}, kBetweenKnocks{5'000};
constexpr milliseconds kPatience{5'000};  // of one try: a host may be busy
constexpr int kTries = 3;                 // a table that is full may end a probe, too

struct Failure {
  std::string what;
};

struct Patience {
  steady_clock::time_point deadline;
  const std::function<bool()>& is_pointless;
};

[[noreturn]] void fail(const std::string& what, int error) { throw Failure{what + ": " + std::strerror(error)}; }

void wait_for(int socket, short events, const Patience& patience) {
  for (milliseconds left{1}; left.count() > 0 && !patience.is_pointless();) {
    left = std::chrono::ceil<milliseconds>(patience.deadline - steady_clock::now());
    pollfd state{socket, events, 0};
    if (poll(&state, 1, static_cast<int>(std::clamp(left, milliseconds(0), kPeriod).count())) > 0) return;
  }
  throw Failure{"a new connection gets no answer"};
}

// Where to connect to reach a listening socket; one of all addresses is reached by loopback.
socklen_t address_of(int listening, sockaddr_storage& address) {
  socklen_t size = sizeof(address);
  if (getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size) != 0) fail("getsockname", errno);
  auto& v4 = reinterpret_cast<sockaddr_in&>(address);
  auto& v6 = reinterpret_cast<sockaddr_in6&>(address);
  if (address.ss_family == AF_INET && v4.sin_addr.s_addr == INADDR_ANY) v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (address.ss_family == AF_INET6 && IN6_IS_ADDR_UNSPECIFIED(&v6.sin6_addr)) v6.sin6_addr = in6addr_loopback;
  return size;
}

Fd connect_to(int listening, const Patience& patience) {
  sockaddr_storage address{};
  const socklen_t size = address_of(listening, address);
  Fd socket(::socket(address.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) fail("no socket for a new connection", errno);
  if (connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), size) == 0) return socket;
  if (errno != EINPROGRESS) fail("connecting", errno);
  wait_for(socket.get(), POLLOUT, patience);
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
  if (!tls) throw Failure{"OpenSSL makes no client"};
  constexpr unsigned char kProtocols[] = {2, 'h', '2'};
  SSL_set_alpn_protos(tls.get(), kProtocols, sizeof(kProtocols));
  BIO* const out = BIO_new(BIO_s_mem());
  SSL_set_bio(tls.get(), BIO_new(BIO_s_mem()), out);
  SSL_connect(tls.get());  // wants to read by now
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(out, &bytes);
  return {bytes, static_cast<size_t>(size)};
}

// The type of its first frame or record is all that is needed.
void expect_answer(int socket, bool is_tls, const Patience& patience) {
  constexpr size_t kHead = 5;
  constexpr char kSettings = 4, kHandshake = 22;
  char head[kHead] = {};
  for (size_t size = 0; size < kHead;) {
    wait_for(socket, POLLIN, patience);
    const ssize_t got = recv(socket, head + size, kHead - size, 0);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (got < 0) fail("a new connection is closed", errno);
    if (got == 0) throw Failure{"a new connection is closed at once"};
    size += static_cast<size_t>(got);
  }
  if (is_tls ? head[0] != kHandshake : head[3] != kSettings)
    throw Failure{is_tls ? "a TLS handshake is refused" : "a new connection gets a strange answer"};
}

}  // namespace

std::string knock(const Door& door, const std::function<bool()>& is_pointless) try {
  const Patience patience{steady_clock::now() + kPatience, is_pointless};
  const Fd socket = connect_to(door.socket, patience);
  const std::string greeting = door.is_tls ? tls_greeting() : http2_greeting();
  if (send(socket.get(), greeting.data(), greeting.size(), MSG_NOSIGNAL) < 0)
    fail("a new connection takes nothing", errno);
  expect_answer(socket.get(), door.is_tls, patience);
  return {};
} catch (const Failure& failure) {
  return failure.what;
}

AdmissionProbe::AdmissionProbe(std::vector<Door> doors, std::function<std::string()> trouble,
                               std::function<void(const std::string&)> tell)
    : doors_(std::move(doors)), trouble_(std::move(trouble)), tell_(std::move(tell)), thread_([this] { run(); }) {}

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
    const std::string now = look();
    if (!is_stopping_ && now != told_) tell_(told_ = now);
  } while (wait(kPeriod));
}

// Knocks now and then, and all the time where something is wrong. Trouble that comes meanwhile is the reason of what a
// knock meets.
std::string AdmissionProbe::look() {
  if (auto trouble = trouble_(); !trouble.empty()) return trouble;
  if (told_.empty() && steady_clock::now() < next_) return {};
  auto obstacle = knock_everywhere();
  next_ = steady_clock::now() + kBetweenKnocks;
  auto trouble = trouble_();
  return trouble.empty() ? obstacle : trouble;
}

std::string AdmissionProbe::knock_everywhere() const {
  for (const Door& door : doors_) {
    std::string what;
    for (int tries = 0; tries < kTries && !(what = knock(door, [this] { return is_pointless(); })).empty(); ++tries)
      continue;
    if (!what.empty()) return "new clients do not get in by " + door.address + ": " + what;
  }
  return {};
}

// False: the probe ends.
bool AdmissionProbe::wait(milliseconds time) {
  std::unique_lock lock(mutex_);
  return !stopping_.wait_for(lock, time, [this] { return is_stopping_.load(); });
}

}  // namespace collided::server
