// Memory of the device.
#include <cuda_runtime.h>

#include <stdexcept>
#include <string>

#include "tests/gpu/contacts/device_bytes.hpp"

namespace collided::test {
namespace {

void check(cudaError_t error) {
  if (error != cudaSuccess) throw std::runtime_error(std::string("device bytes: ") + cudaGetErrorString(error));
}

}  // namespace

DeviceBytes::DeviceBytes(uint64_t bytes) {
  void* memory = nullptr;
  check(cudaMalloc(&memory, bytes));
  bytes_ = {static_cast<std::byte*>(memory), bytes};
  check(cudaMemset(memory, std::to_integer<int>(kPoison), bytes));
  check(cudaDeviceSynchronize());
}
DeviceBytes::~DeviceBytes() { cudaFree(bytes_.data()); }

std::vector<std::byte> DeviceBytes::read() const {
  std::vector<std::byte> bytes(bytes_.size());
  check(cudaMemcpy(bytes.data(), bytes_.data(), bytes.size(), cudaMemcpyDeviceToHost));
  return bytes;
}

}  // namespace collided::test
