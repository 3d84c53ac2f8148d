#pragma once
// The GPUs of this machine. Every thread has a current device, where its calls and launches go; whoever enters the
// engine makes that of its scene current first.

#include <cuda_runtime.h>

#include <string>

#include "gpu/exec/cuda/memory/cuda_call.cuh"
#include "gpu/exec/cuda/memory/device_pool.cuh"
#include "gpu/types.hpp"

namespace collided {

inline Device cuda_device(int ordinal) { return {Backend::kCuda, ordinal}; }

inline DeviceInfo info_of(int ordinal, const cudaDeviceProp& properties) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string uuid = "GPU-";
  for (size_t i = 0; i < sizeof(properties.uuid.bytes); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) uuid += '-';
    const auto byte = static_cast<unsigned char>(properties.uuid.bytes[i]);
    uuid += kDigits[byte >> 4];
    uuid += kDigits[byte & 15];
  }
  return {cuda_device(ordinal), properties.name, properties.totalGlobalMem, uuid};
}

/// Whether a device does what it is asked; after some errors it fails until the process ends. Does not wait for others.
inline bool does_device_work(int device) {
  cudaStream_t stream = nullptr;
  cudaError_t error = cudaSetDevice(device);
  if (error == cudaSuccess) error = cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking);
  if (error == cudaSuccess) {
    error = cudaStreamSynchronize(stream);
    const cudaError_t last = cudaStreamDestroy(stream);
    if (error == cudaSuccess) error = last;
  }
  cudaGetLastError();
  return error == cudaSuccess;
}

/// Memory that this process holds without using it is free, too.
inline uint64_t free_bytes_of(int device) {
  use_device(device);
  size_t free = 0, total = 0;
  check_cuda(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return free + DevicePool::of(device).free_bytes();
}

}  // namespace collided
