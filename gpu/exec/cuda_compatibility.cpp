// Which CUDA devices this build can use.
#include "gpu/exec/cuda_compatibility.hpp"

#include <algorithm>
#include <charconv>
#include <stdexcept>

namespace collided {
namespace {

// NVIDIA keeps code of one minor running on the later ones of its major, but not from or to these systems on a chip.
constexpr Capability kTegra[] = {{5, 3}, {6, 2}, {7, 2}, {8, 7}, {11, 0}};

bool is_tegra(Capability capability) { return std::ranges::find(kTegra, capability) != std::end(kTegra); }

bool is_later_minor(Capability device, Capability built) {
  return device.major == built.major && device.minor >= built.minor;
}

bool code_runs(Capability device, const Architecture& built) {
  if (!built.has_code) return false;
  if (device == built.capability) return true;
  const bool is_portable = !is_tegra(device) && !is_tegra(built.capability);
  return built.scope != Architecture::Scope::kAlone && is_portable && is_later_minor(device, built.capability);
}

bool ptx_compiles(Capability device, const Architecture& built) {
  if (!built.has_ptx) return false;
  switch (built.scope) {
    case Architecture::Scope::kAlone:
      return device == built.capability;
    case Architecture::Scope::kFamily:
      return is_later_minor(device, built.capability);
    case Architecture::Scope::kLater:
      break;
  }
  return device >= built.capability;
}

// Drivers of one major run all runtimes of that major, but compile only PTX of toolkits that are not newer than they
// are.
constexpr int kMajor = 1000, kMinor = 10;

int major_of(int version) { return version / kMajor; }

std::string text_of(int version) {
  return std::to_string(major_of(version)) + "." + std::to_string(version % kMajor / kMinor);
}

// The first driver of each major version, as its release notes have it.
std::string first_driver(int runtime) {
  switch (major_of(runtime)) {
    case 12:
      return "R525";
    case 13:
      return "R580";
    default:
      return "one of CUDA " + std::to_string(major_of(runtime));
  }
}

std::string names_of(std::span<const Architecture> built) {
  std::string names;
  for (const Architecture& each : built) {
    if (!names.empty()) names += ", ";
    names += to_string(each.capability);
    if (!each.has_code) names += " (PTX)";
    if (!each.has_ptx) names += " (code)";
  }
  return names;
}

// As CMake has it: the number of 12.0 is 120.
std::string number_of(Capability capability) {
  return std::to_string(capability.major) + std::to_string(capability.minor);
}

Architecture parse_one(std::string_view word) {
  const auto refuse = [&] { return std::invalid_argument("'" + std::string(word) + "' is no CUDA architecture"); };
  Architecture parsed;
  int number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || number < 10) throw refuse();
  parsed.capability = {number / 10, number % 10};
  std::string_view rest = word.substr(static_cast<size_t>(end - word.data()));
  if (rest.starts_with('a')) parsed.scope = Architecture::Scope::kAlone;
  if (rest.starts_with('f')) parsed.scope = Architecture::Scope::kFamily;
  if (parsed.scope != Architecture::Scope::kLater) rest.remove_prefix(1);
  parsed.has_ptx = rest != "-real";
  parsed.has_code = rest != "-virtual";
  if (!rest.empty() && parsed.has_ptx && parsed.has_code) throw refuse();
  return parsed;
}

}  // namespace

std::string to_string(Capability capability) {
  return std::to_string(capability.major) + "." + std::to_string(capability.minor);
}

std::vector<Architecture> parse_architectures(std::string_view list) {
  std::vector<Architecture> parsed;
  for (size_t from = 0; from <= list.size();) {
    const size_t comma = std::min(list.find(',', from), list.size());
    parsed.push_back(parse_one(list.substr(from, comma - from)));
    from = comma + 1;
  }
  return parsed;
}

Kernels kernels_for(Capability device, std::span<const Architecture> built, const CudaMachine& machine) {
  const auto has = [&](auto fits) {
    return std::ranges::any_of(built, [&](const auto& each) { return fits(device, each); });
  };
  if (!machine.ignores_code && has(code_runs)) return Kernels::kCode;
  if (!machine.ignores_ptx && has(ptx_compiles)) return Kernels::kPtx;
  return Kernels::kNone;
}

std::string machine_obstacle(const CudaMachine& machine) {
  if (machine.driver == 0 && machine.has_module)
    return "the NVIDIA driver's library libcuda.so.1 cannot be used: either the driver is too old, and driver " +
           first_driver(machine.runtime) +
           " or later helps, or a container was started without it (NVIDIA Container Toolkit)";
  if (machine.driver == 0) return "this machine has no NVIDIA driver";
  if (major_of(machine.driver) < major_of(machine.runtime))
    return "the NVIDIA driver is too old: it supports CUDA " + text_of(machine.driver) +
           ", and this build needs CUDA " + std::to_string(major_of(machine.runtime)) + "; install driver " +
           first_driver(machine.runtime) + " or later";
  if (!machine.error.empty()) return "CUDA cannot start: " + machine.error;
  return machine.has_devices ? "" : "this machine has no NVIDIA GPU that the daemon may see";
}

bool is_absent(const CudaMachine& machine) {
  if (machine.driver == 0) return !machine.has_module;
  return machine.error.empty() && !machine.has_devices;
}

std::string device_obstacle(Capability device, std::span<const Architecture> built, const CudaMachine& machine) {
  switch (kernels_for(device, built, machine)) {
    case Kernels::kCode:
      return "";
    case Kernels::kPtx:
      if (machine.driver >= machine.runtime) return "";
      return "the NVIDIA driver is too old: this build has no code for compute capability " + to_string(device) +
             ", only PTX, which a driver of CUDA " + text_of(machine.runtime) +
             " or later compiles, and this one supports CUDA " + text_of(machine.driver);
    case Kernels::kNone:
      break;
  }
  const std::string setting = machine.ignores_code  ? "; CUDA_FORCE_PTX_JIT=1 takes the code away"
                              : machine.ignores_ptx ? "; CUDA_DISABLE_PTX_JIT=1 takes the PTX away"
                                                    : "";
  return "this build has no kernels for compute capability " + to_string(device) + ", only for " + names_of(built) +
         setting + "; a build with -DCOLLIDED_CUDA_ARCHITECTURES=" + number_of(device) + " has them, if CUDA " +
         std::to_string(major_of(machine.runtime)) + " supports it";
}

}  // namespace collided
