#pragma once
// What scenes live on: CPU cores of the host, or one of its GPUs.

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace collided {

enum class Backend { kCpu, kCuda };

/// CUDA devices have the ordinals of the driver, which `CUDA_VISIBLE_DEVICES` changes. All devices of the CPU share the
/// host's cores and memory: they differ by the threads and memory that whoever makes scenes gives them.
struct Device {
  Backend backend = Backend::kCpu;
  int ordinal = 0;  ///< >= 0

  friend auto operator<=>(const Device&, const Device&) = default;
};

/// As "cuda:1".
std::string to_string(const Device& device);

/// "cpu" and "cuda" are those of ordinal 0. Nothing for what names no device.
std::optional<Device> parse_device(std::string_view text);

struct DeviceInfo {
  Device device = {};
  std::string name = {};
  uint64_t memory_bytes = 0;    ///< 0 for the CPU, which shares the host's
  std::string uuid = {};        ///< "GPU-" and 32 hexadecimal digits, as the driver's tools name it; empty for the CPU
  std::string capability = {};  ///< compute capability, such as "9.0"; empty for the CPU
  /// True if this build has only PTX for the device: its driver compiles the kernels, or takes them from its cache.
  bool needs_compilation = false;
};

/// A CUDA device that scenes cannot live on, or the reason why there is none at all.
struct UnusableDevice {
  std::optional<Device> device = {};  ///< none: the reason applies to all CUDA devices
  std::string name = {};              ///< empty for all
  std::string reason = {};            ///< why, and what would help
  bool is_absent = false;             ///< True if the machine has no GPU or no driver, which is no fault.
};

/// As "cuda:1 (NVIDIA H100): REASON"; the reason alone for all devices.
std::string to_string(const UnusableDevice& unusable);

}  // namespace collided
