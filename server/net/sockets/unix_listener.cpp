// Unix sockets by their paths.
#include "server/net/sockets/unix_listener.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace collided::server {
namespace {

constexpr size_t kLongestPath = sizeof(sockaddr_un::sun_path) - 1;

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, kLongestPath);
  return address;
}

const sockaddr* generic(const sockaddr_un& address) { return reinterpret_cast<const sockaddr*>(&address); }

[[noreturn]] void throw_cannot(const std::string& path, const std::string& why) {
  throw std::runtime_error("cannot listen on " + path + ": " + why);
}

void check_path(const std::string& path) {
  if (path.empty() || path.size() > kLongestPath)
    throw_cannot(path, "a socket's path has 1 to " + std::to_string(kLongestPath) + " bytes, but this one has " +
                           std::to_string(path.size()));
}

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

// Finding a socket stale, removing it and binding another must be one step: otherwise two daemons could both do it, and
// the second would remove the socket of the first. The folder is locked, so that no lock file is left behind.
Fd lock_folder_of(const std::string& path) {
  constexpr std::chrono::milliseconds kPatience{5000}, kPoll{5};
  const std::string folder = folder_of(path);
  Fd lock(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!lock) throw_cannot(path, "folder " + folder + ": " + std::strerror(errno));
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) throw_cannot(path, "locking " + folder + ": " + std::strerror(errno));
    if (std::chrono::steady_clock::now() > deadline)
      throw_cannot(path, "another process has kept the folder " + folder + " locked for 5 s");
    std::this_thread::sleep_for(kPoll);
  }
  return lock;
}

void remove_stale(const std::string& path) {
  struct stat file {};
  if (lstat(path.c_str(), &file) != 0) return;
  if (!S_ISSOCK(file.st_mode)) throw_cannot(path, "the path exists and is not a socket");
  if (is_served(path)) throw_cannot(path, "another daemon serves there");
  unlink(path.c_str());
}

}  // namespace

bool is_served(const std::string& path) {
  const sockaddr_un address = address_of(path);
  const Fd probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!probe) return false;
  // A full backlog (EAGAIN) counts as served, and so does a socket of another type.
  return connect(probe.get(), generic(address), sizeof(address)) == 0 || errno == EAGAIN || errno == EPROTOTYPE;
}

UnixListener::UnixListener(const std::string& path, const Options& options) : path_(path) {
  check_path(path);
  const Fd lock = lock_folder_of(path);
  remove_stale(path);
  bind_and_listen(options);
}

void UnixListener::bind_and_listen(const Options& options) {
  socket_ = Fd(::socket(AF_UNIX, options.type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const sockaddr_un address = address_of(path_);
  if (!socket_ || bind(socket_.get(), generic(address), sizeof(address)) != 0)
    throw_cannot(path_, std::strerror(errno));
  // Nobody can connect before listen(), and the mode is set by then.
  struct stat file {};
  const bool has_mode = !options.mode || chmod(path_.c_str(), *options.mode) == 0;
  if (!has_mode || listen(socket_.get(), SOMAXCONN) != 0 || lstat(path_.c_str(), &file) != 0) {
    const int error = errno;
    unlink(path_.c_str());
    throw_cannot(path_, std::strerror(error));
  }
  device_ = file.st_dev;
  inode_ = file.st_ino;
}

Fd UnixListener::accept() const { return Fd(accept4(socket(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)); }

UnixListener::~UnixListener() {
  struct stat file {};
  if (lstat(path_.c_str(), &file) == 0 && file.st_dev == device_ && file.st_ino == inode_) unlink(path_.c_str());
}

}  // namespace collided::server
