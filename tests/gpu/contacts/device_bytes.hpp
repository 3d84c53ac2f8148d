#pragma once
// Memory of the backend under test, which the tests write and read.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace collided::test {

/// Filled with kPoison. On CUDA memory of the device, else of the host. Throws std::runtime_error.
class DeviceBytes {
 public:
  static constexpr std::byte kPoison{0xcd};

  explicit DeviceBytes(uint64_t bytes);
  DeviceBytes(const DeviceBytes&) = delete;
  DeviceBytes& operator=(const DeviceBytes&) = delete;
  ~DeviceBytes();

  std::span<std::byte> bytes() const { return bytes_; }
  std::vector<std::byte> read() const;

 private:
  std::span<std::byte> bytes_;
};

}  // namespace collided::test
