// Memory that a client shares with the daemon. Touching a page that the file no longer has would kill the daemon with
// SIGBUS: hence the seal. A memfd of huge pages can lack pages even when sealed: hence ordinary pages only.
#include "server/transport/local/shared_region.hpp"

#include <fcntl.h>
#include <linux/magic.h>
#include <spdlog/fmt/fmt.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/vfs.h>

#include <cerrno>
#include <cstring>

#include "proto/constants.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr auto kFile = "open.file";

[[noreturn]] void throw_file(const std::string& what) { throw InvalidInput(kFile, std::string(kFile) + " " + what); }

void check_file(int fd, uint64_t wanted) {
  struct stat file {};
  struct statfs system {};
  const int seals = fcntl(fd, F_GET_SEALS);
  if (seals < 0 || fstat(fd, &file) != 0 || fstatfs(fd, &system) != 0 || !S_ISREG(file.st_mode) ||
      system.f_type != TMPFS_MAGIC)
    throw_file("is not a memfd of ordinary pages");
  if (!(seals & F_SEAL_SHRINK)) throw_file("lacks the seal F_SEAL_SHRINK");
  if (static_cast<uint64_t>(file.st_size) < wanted)
    throw_file(fmt::format("has {} bytes, but input_bytes and output_bytes are {} together", file.st_size, wanted));
}

// The engine names its argument, not the protocol's field.
std::unique_ptr<SharedMemory> open_device(std::span<const std::byte> handle, const Device& device,
                                          const std::string& field) try {
  return open_device_memory(device, handle);
} catch (const InvalidInput& e) {
  throw InvalidInput(field, field + ": " + e.what());
}

}  // namespace

std::shared_ptr<SharedRegion> SharedRegion::map(const Fd& file, const RegionSize& size, const Device& device) {
  std::shared_ptr<SharedRegion> region(new SharedRegion);
  if (size.input + size.output > 0) region->map_file(file, size);
  if (size.input == 0) return region;
  region->registered_ = register_host_memory(device, region->mapped_.first(size.input));
  region->input_ = region->registered_->bytes();
  return region;
}

std::shared_ptr<SharedRegion> SharedRegion::open(std::span<const std::byte> handle, const Device& device,
                                                 const Fd& file, uint64_t output) {
  std::shared_ptr<SharedRegion> region(new SharedRegion);
  if (output > 0) region->map_file(file, {0, output});
  region->registered_ = open_device(handle, device, "open.cuda_ipc_handle");
  region->input_ = region->registered_->bytes();
  region->is_host_ = false;
  return region;
}

void SharedRegion::open_output(std::span<const std::byte> handle, const Device& device, uint64_t bytes) {
  auto memory = open_device(handle, device, "open.output_cuda_ipc_handle");
  if (memory->bytes().size() < bytes)
    throw InvalidInput("open.output_bytes",
                       fmt::format("open.output_bytes is {}, but the memory of open.output_cuda_ipc_handle has {}",
                                   bytes, memory->bytes().size()));
  device_output_ = std::move(memory);
  output_ = device_output_->bytes().first(bytes);
}

void SharedRegion::map_file(const Fd& file, const RegionSize& size) {
  const uint64_t bytes = size.input + size.output;
  check_file(file.get(), bytes);
  void* const start = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file.get(), 0);
  if (start == MAP_FAILED && errno == EPERM) throw_file("has a seal that prevents the daemon from writing to it");
  if (start == MAP_FAILED)
    throw LimitExceeded(kFile,
                        fmt::format("{} has {} bytes, which cannot be mapped: {}", kFile, bytes, std::strerror(errno)));
  mapped_ = {static_cast<std::byte*>(start), bytes};
  output_ = mapped_.subspan(size.input);
}

SharedRegion::~SharedRegion() {
  registered_.reset();
  device_output_.reset();
  if (!mapped_.empty()) munmap(mapped_.data(), mapped_.size());
}

std::span<std::byte> SharedRegion::output_part(uint64_t frame, uint32_t window) const {
  const size_t bytes = output_.size() / window / v1::kPageBytes * v1::kPageBytes;
  return output_.subspan(frame % window * bytes, bytes);
}

std::span<const std::byte> SharedRegion::input(uint64_t offset, uint64_t size, const std::string& path) const {
  if (size > input_.size() || offset > input_.size() - size)
    throw InvalidInput(path, fmt::format("{} is {} bytes at offset {}, but the input region has {}", path, size, offset,
                                         input_.size()));
  if (offset % v1::kRangeAlignment != 0)
    throw InvalidInput(path + ".offset",
                       fmt::format("{}.offset is {}, but must be a multiple of {}", path, offset, v1::kRangeAlignment));
  return input_.subspan(offset, size);
}

}  // namespace collided::server
