// Who is at the other end of a Unix socket, and whether a token may be sent there.

#include "client/cpp/transport/local/local_peer.hpp"

#include <grpcpp/support/status_code_enum.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <utility>

#include "client/cpp/error.hpp"

namespace collided::client {

namespace {

constexpr uid_t kRoot = 0;

/// "unix:/path" or "unix:///path" to "/path"; empty for other addresses.
std::string socket_path(const std::string& grpc_address) {
  constexpr std::string_view kScheme = "unix:", kAuthority = "//";
  if (!grpc_address.starts_with(kScheme)) return "";
  const std::string path = grpc_address.substr(kScheme.size());
  return path.starts_with(kAuthority) ? path.substr(kAuthority.size()) : path;
}

[[noreturn]] void refuse(const std::string& why) { throw Error(grpc::PERMISSION_DENIED, why, "options.local"); }

void check_folder(const std::string& path, TrustedUsers& trusted) {
  const std::string folder = std::filesystem::absolute(path).parent_path().string();
  struct stat about {};
  if (stat(folder.c_str(), &about) != 0) refuse("folder " + folder + " cannot be inspected: " + std::strerror(errno));
  if (!trusted.contains(about.st_uid))
    refuse("folder " + folder + " of the daemon's local socket belongs to user " + std::to_string(about.st_uid) +
           "; trusted are " + trusted.text() + " (options.local.daemon_user)");
  if ((about.st_mode & S_IWOTH) != 0 && (about.st_mode & S_ISVTX) == 0)
    refuse("folder " + folder + " of the daemon's local socket can be written to by every user, and is not sticky");
}

}  // namespace

void limit_sending(const LocalFd& socket, std::chrono::milliseconds time) {
  using std::chrono::milliseconds;
  const auto limit = std::clamp<milliseconds>(time, milliseconds(1), std::chrono::hours(240));  // 0 would be none
  const timeval timeout{limit.count() / 1000, limit.count() % 1000 * 1000};
  setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof(timeout));
}

LocalFd connect_to_socket(const std::string& path, int kind, std::chrono::milliseconds patience) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof(address.sun_path))
    throw Error(grpc::INVALID_ARGUMENT, "local_socket is \"" + path + "\", which is not a socket path");
  path.copy(address.sun_path, path.size());
  LocalFd socket(::socket(AF_UNIX, kind | SOCK_CLOEXEC, 0));
  if (socket.get() >= 0) limit_sending(socket, patience);
  if (socket.get() < 0 || connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
    throw Error(grpc::UNAVAILABLE, "no daemon answers at " + path + ": " + std::strerror(errno));
  return socket;
}

uid_t user_at(const LocalFd& socket) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  if (getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
    throw Error(grpc::UNAVAILABLE, std::string("cannot identify the user at a local socket: ") + std::strerror(errno));
  return peer.uid;
}

TrustedUsers::TrustedUsers(std::string grpc_address, int64_t daemon_user, std::chrono::milliseconds patience)
    : grpc_address_(std::move(grpc_address)), patience_(patience), users_{geteuid(), kRoot} {
  if (daemon_user >= 0) users_.push_back(static_cast<uid_t>(daemon_user));
}

bool TrustedUsers::contains(uid_t user) {
  const auto is_known = [&] { return std::find(users_.begin(), users_.end(), user) != users_.end(); };
  if (is_known() || grpc_address_.empty()) return is_known();
  const std::string path = socket_path(std::exchange(grpc_address_, ""));
  if (!path.empty()) try {
      users_.push_back(user_at(connect_to_socket(path, SOCK_STREAM, patience_)));
    } catch (const Error&) {  // an address that only gRPC understands adds no trusted user
    }
  return is_known();
}

std::string TrustedUsers::text() const {
  std::string text;
  for (const uid_t user : std::set(users_.begin(), users_.end()))
    text += (text.empty() ? "" : ", ") + std::to_string(user);
  return text;
}

void check_trusted(const LocalFd& socket, const std::string& path, TrustedUsers trusted) {
  if (const uid_t user = user_at(socket); !trusted.contains(user))
    refuse("user " + std::to_string(user) + " listens at the daemon's local socket " + path + "; trusted are " +
           trusted.text() + " (options.local.daemon_user)");
  check_folder(path, trusted);
}

}  // namespace collided::client
