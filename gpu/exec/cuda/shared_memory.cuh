#pragma once
// Memory of others that a GPU reads: the host's, pinned in place, and that of another process on the device.

#include <cuda.h>
#include <cuda_runtime.h>

#include <cstring>
#include <span>

#include "gpu/exec/cuda/device.cuh"

namespace collided {

class RegisteredMemory final : public SharedMemory {
 public:
  explicit RegisteredMemory(int device, std::span<std::byte> memory) : device_(device), memory_(memory) {
    if (memory.empty()) return;
    check(cudaSetDevice(device));
    check(cudaHostRegister(memory.data(), memory.size(), cudaHostRegisterPortable));
  }
  RegisteredMemory(const RegisteredMemory&) = delete;
  RegisteredMemory& operator=(const RegisteredMemory&) = delete;
  ~RegisteredMemory() override {
    if (memory_.empty()) return;
    cudaSetDevice(device_);
    if (cudaHostUnregister(memory_.data()) != cudaSuccess) cudaGetLastError();
  }

  std::span<std::byte> bytes() const override { return memory_; }

 private:
  void check(cudaError_t error) const {
    if (error == cudaSuccess) return;
    cudaGetLastError();
    throw DeviceError("host memory of " + std::to_string(memory_.size()) +
                      " bytes cannot be pinned: " + cudaGetErrorString(error));
  }

  int device_;
  std::span<std::byte> memory_;
};

/// Of this device, or of one that it reaches directly: the driver does not tell them apart.
class DeviceMemoryOfOthers final : public SharedMemory {
 public:
  DeviceMemoryOfOthers(int device, std::span<const std::byte> handle) : device_(device) {
    cudaIpcMemHandle_t opened;
    if (handle.size() != sizeof(opened))
      throw InvalidInput("handle", "handle has " + std::to_string(handle.size()) + " bytes, one of device memory has " +
                                       std::to_string(sizeof(opened)));
    std::memcpy(&opened, handle.data(), sizeof(opened));
    use_device(device);
    const cudaError_t error = cudaIpcOpenMemHandle(&memory_, opened, cudaIpcMemLazyEnablePeerAccess);
    if (error != cudaSuccess) refuse(error);
    try {
      bytes_ = bytes_from(memory_);
    } catch (...) {
      cudaIpcCloseMemHandle(memory_);
      throw;
    }
  }
  DeviceMemoryOfOthers(const DeviceMemoryOfOthers&) = delete;
  DeviceMemoryOfOthers& operator=(const DeviceMemoryOfOthers&) = delete;
  ~DeviceMemoryOfOthers() override {
    cudaSetDevice(device_);
    if (cudaIpcCloseMemHandle(memory_) != cudaSuccess) cudaGetLastError();
  }

  std::span<std::byte> bytes() const override { return {static_cast<std::byte*>(memory_), bytes_}; }

 private:
  /// A device that works has refused the handle.
  [[noreturn]] void refuse(cudaError_t error) const {
    cudaGetLastError();
    const std::string text =
        "handle names no memory that " + to_string(cuda_device(device_)) + " can open: " + cudaGetErrorString(error);
    if (!does_device_work(device_)) throw DeviceError(text);
    throw InvalidInput("handle", text);
  }

  /// From an address to the end of its allocation. Only the driver knows, which this program does not link.
  static uint64_t bytes_from(void* memory) {
    void* entry = nullptr;
    cudaDriverEntryPointQueryResult result = cudaDriverEntryPointSymbolNotFound;
#if CUDART_VERSION >= 12050
    constexpr unsigned kSince = 12000;
    check_cuda(cudaGetDriverEntryPointByVersion("cuMemGetAddressRange", &entry, kSince, cudaEnableDefault, &result),
               "cuMemGetAddressRange");
#else
    check_cuda(cudaGetDriverEntryPoint("cuMemGetAddressRange", &entry, cudaEnableDefault, &result),
               "cuMemGetAddressRange");
#endif
    if (result != cudaDriverEntryPointSuccess)
      throw DeviceError("cuMemGetAddressRange: the driver has no such function");
    CUdeviceptr begin = 0;
    size_t bytes = 0;
    const CUdeviceptr address = reinterpret_cast<CUdeviceptr>(memory);
    const auto address_range = reinterpret_cast<CUresult(CUDAAPI*)(CUdeviceptr*, size_t*, CUdeviceptr)>(entry);
    if (address_range(&begin, &bytes, address) != CUDA_SUCCESS)
      throw DeviceError("cuMemGetAddressRange: the driver does not know the memory of a handle");
    return begin + bytes - address;
  }

  int device_;
  void* memory_ = nullptr;
  uint64_t bytes_ = 0;
};

}  // namespace collided
