#include "server/private_folder.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "server/config/file/config_error.hpp"
#include "server/net/sockets/fd.hpp"

namespace collided::server {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxBytes = 90;  // the path of a socket in it has at most 107
constexpr int kForever = -1;

void check_standard_input() {
  struct stat input {};
  if (fstat(STDIN_FILENO, &input) == 0 && (S_ISFIFO(input.st_mode) || S_ISSOCK(input.st_mode) || isatty(STDIN_FILENO)))
    return;
  throw ConfigError("--private needs a pipe, a socket or a terminal as standard input: the daemon ends when it closes");
}

// Returns true if a path means the same in an address, where ',', '%', '?' and '#' are special.
bool is_plain(const std::string& path) {
  return std::ranges::all_of(path, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("/._-~+").find(c) != std::string_view::npos;
  });
}

// Returns its absolute path, or why there is none.
std::string make_folder() {
  std::error_code error;
  for (const fs::path& parent : {fs::temp_directory_path(error), fs::path("/tmp")}) {
    std::string path = (parent / "collided-XXXXXX").string();
    if (!path.starts_with('/') || path.size() > kMaxBytes || !is_plain(path)) continue;
    if (mkdtemp(path.data()) != nullptr) return path;
  }
  return "no folder for sockets can be made in $TMPDIR or /tmp: " + std::string(strerror(errno));
}

// Waits for the other end of `daemon` or `input` to close. Returns true if that of `daemon` has.
bool wait_until_gone(int daemon, int input, int milliseconds) {
  std::array<pollfd, 2> ends{{{daemon, 0, 0}, {input, POLLRDHUP, 0}}};
  while (poll(ends.data(), ends.size(), milliseconds) < 0 && errno == EINTR) {
  }
  return ends[0].revents != 0;
}

// Makes the folder as well: the daemon may be killed at any time, and would leave one that it has just made. Its path
// goes to `daemon`, whose other end closes with the daemon.
[[noreturn]] void tidy_up(int daemon, pid_t pid, double seconds_to_stop) {
  prctl(PR_SET_NAME, "collided-tidy");
  // Whoever ends the terminal's or the daemon's processes ends the daemon, which this one must outlive.
  setsid();
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) signal(number, SIG_IGN);
  const std::string folder = make_folder();
  send(daemon, folder.data(), folder.size(), MSG_NOSIGNAL);
  if (!folder.starts_with('/')) _exit(1);
  if (!wait_until_gone(daemon, STDIN_FILENO, kForever)) {
    kill(pid, SIGTERM);
    if (!wait_until_gone(daemon, -1, static_cast<int>(seconds_to_stop * 1000))) {
      kill(pid, SIGKILL);
      wait_until_gone(daemon, -1, kForever);
    }
  }
  std::error_code error;
  fs::remove_all(folder, error);
  _exit(0);
}

// Lets this process get SIGTERM once the other end of a socket has closed: without `collided-tidy` nobody would see
// that standard input closes. Nothing may ever be sent to the socket: the signal of a message can come after the
// message was read.
void end_with(int socket) {
  if (fcntl(socket, F_SETOWN, getpid()) != 0 || fcntl(socket, F_SETSIG, SIGTERM) != 0 ||
      fcntl(socket, F_SETFL, O_ASYNC) != 0)
    throw std::system_error(errno, std::generic_category(), "fcntl");
}

struct SocketPair {
  SocketPair() {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
      throw std::system_error(errno, std::generic_category(), "socketpair");
    here = Fd(ends[0]);
    there = Fd(ends[1]);
  }

  Fd here, there;
};

}  // namespace

std::string make_private_folder(double seconds_to_stop) {
  check_standard_input();
  if (!isatty(STDIN_FILENO)) setpgid(0, 0);
  SocketPair replies, lives;
  const pid_t pid = getpid();
  const pid_t tidy = fork();
  if (tidy == 0) {
    replies.here = Fd();
    lives.here = Fd();
    tidy_up(replies.there.get(), pid, seconds_to_stop);
  }
  if (tidy < 0) throw std::system_error(errno, std::generic_category(), "fork");
  replies.there = Fd();
  lives.there = Fd();
  std::array<char, 256> reply{};
  const ssize_t size = recv(replies.here.get(), reply.data(), reply.size(), 0);
  if (size <= 0) throw std::runtime_error("collided-tidy has ended before it made a folder for sockets");
  const std::string folder(reply.data(), static_cast<size_t>(size));
  if (!folder.starts_with('/')) throw std::runtime_error(folder);
  end_with(lives.here.get());
  replies.here.release();  // both stay open until this process is gone
  lives.here.release();
  return folder;
}

}  // namespace collided::server
