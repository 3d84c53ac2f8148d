#pragma once
// Calls of the CUDA runtime, whose errors become exceptions.

#include <cuda_runtime.h>

#include <string>

#include "gpu/types.hpp"

namespace collided {

inline void check_cuda(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();
  const std::string text = std::string(what) + ": " + cudaGetErrorString(error);
  if (error == cudaErrorMemoryAllocation) throw ResourceExhausted(text);
  throw DeviceError(text);
}

/// For the calling thread; returns the device.
inline int use_device(int device) {
  check_cuda(cudaSetDevice(device), "cudaSetDevice");
  return device;
}

}  // namespace collided
