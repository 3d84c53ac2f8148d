#pragma once
// The CUDA driver's own calls, for what is asked before kernels are loaded. With CUDA_MODULE_LOADING=EAGER the first
// call of the runtime, whichever it is, loads them all; where the driver has to compile them, that takes minutes.

#include <cuda.h>
#include <dlfcn.h>

#include <optional>
#include <string>
#include <type_traits>

namespace collided {

/// Functions of libcuda.so.1.
struct CudaDriver {
  decltype(&cuInit) init;
  decltype(&cuDriverGetVersion) version;
  decltype(&cuDeviceGetCount) count;
  decltype(&cuDeviceGet) device;
  decltype(&cuDeviceGetName) name;
  decltype(&cuDeviceTotalMem) memory;
  decltype(&cuDeviceGetUuid) uuid;
  decltype(&cuDeviceGetAttribute) attribute;
  decltype(&cuGetErrorString) describe;

  /// Absent where the machine has no driver, or one that lacks a function.
  static std::optional<CudaDriver> load() {
    void* const library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);  // it stays: the runtime uses it as well
    if (library == nullptr) return std::nullopt;
    CudaDriver driver{};
    bool is_whole = true;
    const auto find = [&](auto& function, const char* symbol) {
      function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(library, symbol));
      is_whole = is_whole && function != nullptr;
    };
    find(driver.init, "cuInit");
    find(driver.version, "cuDriverGetVersion");
    find(driver.count, "cuDeviceGetCount");
    find(driver.device, "cuDeviceGet");
    find(driver.name, "cuDeviceGetName");
    find(driver.memory, "cuDeviceTotalMem_v2");
    find(driver.uuid, "cuDeviceGetUuid_v2");
    find(driver.attribute, "cuDeviceGetAttribute");
    find(driver.describe, "cuGetErrorString");
    return is_whole ? std::optional(driver) : std::nullopt;
  }

  std::string text_of(CUresult error) const {
    const char* text = nullptr;
    return describe(error, &text) == CUDA_SUCCESS ? text : "error " + std::to_string(error);
  }
};

}  // namespace collided
