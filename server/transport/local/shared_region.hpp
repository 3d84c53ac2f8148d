#pragma once
// Memory that a client shares with the daemon: positions in, contacts out. Either may be memory of the device.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "gpu/detector.hpp"
#include "server/net/sockets/fd.hpp"

namespace collided::server {

/// Bytes of the two parts of a region, input first.
struct RegionSize {
  uint64_t input = 0, output = 0;
};

/// The client can change the memory at any time, so readers copy it first and check the copy. It cannot take the memory
/// away.
class SharedRegion {
 public:
  /// Maps a memfd that the client has sealed against shrinking. Throws InvalidInput for any other file, a missing seal
  /// or a file that is too small, LimitExceeded if memory is short, DeviceError.
  static std::shared_ptr<SharedRegion> map(const Fd& file, const RegionSize& size, const Device& device);
  /// As map(), but the input is memory of the device, of a cudaIpcMemHandle_t, and the file (none if `output` is 0)
  /// holds only the output. Throws InvalidInput for a bad handle or one that the device does not reach, DeviceError.
  static std::shared_ptr<SharedRegion> open(std::span<const std::byte> handle, const Device& device, const Fd& file,
                                            uint64_t output);
  /// Makes the first `bytes` of memory of the device, of a cudaIpcMemHandle_t, the output. Throws InvalidInput for a
  /// bad handle, one that the device does not reach or less memory, DeviceError.
  void open_output(std::span<const std::byte> handle, const Device& device, uint64_t bytes);
  ~SharedRegion();
  SharedRegion(const SharedRegion&) = delete;
  SharedRegion& operator=(const SharedRegion&) = delete;

  /// A range of the input, as the backend reads it. Throws InvalidInput, naming `path`, for a range outside the input.
  std::span<const std::byte> input(uint64_t offset, uint64_t size, const std::string& path) const;
  /// Whether the host can read the input.
  bool is_host() const { return is_host_; }
  std::span<std::byte> output() const { return output_; }
  /// The part of it that the `frame`th frame of a stream has.
  std::span<std::byte> output_part(uint64_t frame, uint32_t window) const;
  /// Whether the output is for the device to write, and not for the host.
  bool has_device_output() const { return device_output_ != nullptr; }

 private:
  SharedRegion() = default;
  void map_file(const Fd& file, const RegionSize& size);

  std::span<std::byte> mapped_, output_;
  std::span<const std::byte> input_;
  std::unique_ptr<SharedMemory> registered_, device_output_;
  bool is_host_ = true;
};

}  // namespace collided::server
