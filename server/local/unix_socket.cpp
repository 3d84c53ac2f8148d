// Unix sockets by their paths.
#include "server/local/unix_socket.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

namespace collided::server {
namespace {

constexpr int kBacklog = 128;

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  return address;
}

const sockaddr* generic(const sockaddr_un& address) { return reinterpret_cast<const sockaddr*>(&address); }

[[noreturn]] void throw_cannot(const std::string& path, const std::string& why) {
  throw std::runtime_error(fmt::format("cannot listen on {}: {}", path, why));
}

void check_path(const std::string& path) {
  constexpr size_t kLongest = sizeof(sockaddr_un::sun_path) - 1;
  if (path.empty() || path.size() > kLongest)
    throw_cannot(path, fmt::format("a socket's path has 1 to {} bytes, but this one has {}", kLongest, path.size()));
}

void remove_stale(const std::string& path) {
  struct stat file {};
  if (lstat(path.c_str(), &file) != 0) return;
  if (!S_ISSOCK(file.st_mode)) throw_cannot(path, "another file is there");
  if (is_served(path)) throw_cannot(path, "another daemon serves there");
  unlink(path.c_str());
}

}  // namespace

bool is_served(const std::string& path) {
  const sockaddr_un address = address_of(path);
  const Fd probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!probe) return false;
  // A full backlog (EAGAIN) is an answer, too, and so is that the socket is of another type.
  return connect(probe.get(), generic(address), sizeof(address)) == 0 || errno == EAGAIN || errno == EPROTOTYPE;
}

uid_t peer_uid(int socket) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
    throw std::system_error(errno, std::generic_category(), "SO_PEERCRED");
  return peer.uid;
}

PacketListener::PacketListener(const std::string& path, mode_t mode) : path_(path) {
  check_path(path);
  remove_stale(path);
  socket_ = Fd(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const sockaddr_un address = address_of(path);
  if (!socket_ || bind(socket_.get(), generic(address), sizeof(address)) != 0) throw_cannot(path, std::strerror(errno));
  // Nobody can connect before listen(): by then the mode holds.
  struct stat file {};
  if (chmod(path.c_str(), mode) != 0 || listen(socket_.get(), kBacklog) != 0 || lstat(path.c_str(), &file) != 0) {
    const int error = errno;
    unlink(path.c_str());
    throw_cannot(path, std::strerror(error));
  }
  device_ = file.st_dev;
  inode_ = file.st_ino;
}

PacketListener::~PacketListener() {
  struct stat file {};
  if (lstat(path_.c_str(), &file) == 0 && file.st_dev == device_ && file.st_ino == inode_) unlink(path_.c_str());
}

Fd PacketListener::accept() const { return Fd(accept4(socket_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)); }

}  // namespace collided::server
