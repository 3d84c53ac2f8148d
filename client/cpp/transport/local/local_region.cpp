// Memory that a client shares with the daemon on its host.

#include "client/cpp/transport/local/local_region.hpp"

#include <fcntl.h>
#include <grpcpp/support/status_code_enum.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "client/cpp/error.hpp"

namespace collided::client {

LocalFd::LocalFd(LocalFd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

LocalFd& LocalFd::operator=(LocalFd&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

LocalFd::~LocalFd() {
  if (fd_ >= 0) close(fd_);
}

LocalRegion::LocalRegion(uint64_t bytes) {
  if (bytes == 0) return;
  file_ = LocalFd(memfd_create("collided", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
  void* start = MAP_FAILED;
  if (file_.get() >= 0 && ftruncate(file_.get(), static_cast<off_t>(bytes)) == 0 &&
      fcntl(file_.get(), F_ADD_SEALS, kSeals) == 0)
    start = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0);
  if (start == MAP_FAILED)
    throw Error(grpc::RESOURCE_EXHAUSTED,
                "no shared memory of " + std::to_string(bytes) + " bytes: " + std::strerror(errno));
  bytes_ = {static_cast<std::byte*>(start), bytes};
}

LocalRegion::~LocalRegion() {
  if (!bytes_.empty()) munmap(bytes_.data(), bytes_.size());
}

}  // namespace collided::client
