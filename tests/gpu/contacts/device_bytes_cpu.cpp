// Memory of the CPU backend, aligned like a device's.
#include <algorithm>
#include <new>

#include "tests/gpu/contacts/device_bytes.hpp"

namespace collided::test {
namespace {

constexpr std::align_val_t kAlignment{256};

}  // namespace

DeviceBytes::DeviceBytes(uint64_t bytes) : bytes_(static_cast<std::byte*>(::operator new(bytes, kAlignment)), bytes) {
  std::ranges::fill(bytes_, kPoison);
}
DeviceBytes::~DeviceBytes() { ::operator delete(bytes_.data(), kAlignment); }

std::vector<std::byte> DeviceBytes::read() const { return {bytes_.begin(), bytes_.end()}; }

}  // namespace collided::test
