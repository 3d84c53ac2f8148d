// The CUDA devices of this machine, and why some of them cannot be used. Whoever asks for them has not waited for
// kernels: that is announced, and done, later.
#include <cuda_runtime.h>

#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "gpu/exec/cuda/device.cuh"
#include "gpu/exec/cuda/driver.cuh"
#include "gpu/exec/cuda_compatibility.hpp"
#include "gpu/scene/backends/backends.hpp"

namespace collided {
namespace {

const std::vector<Architecture>& built() {
  static const std::vector<Architecture> architectures = parse_architectures(COLLIDED_CUDA_ARCHITECTURES);
  return architectures;
}

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && std::string_view(value) == "1";
}

struct Survey {
  std::vector<DeviceInfo> usable = {};
  std::vector<UnusableDevice> unusable = {};
};

// `count`: of the devices, if there are any.
CudaMachine machine_of(const std::optional<CudaDriver>& driver, int& count) {
  CudaMachine machine{.runtime = CUDART_VERSION,
                      .ignores_code = is_set("CUDA_FORCE_PTX_JIT"),
                      .ignores_ptx = is_set("CUDA_DISABLE_PTX_JIT")};
  std::error_code ignored;
  machine.has_module = std::filesystem::exists("/proc/driver/nvidia/version", ignored);
  if (!driver) return machine;
  driver->version(&machine.driver);
  CUresult error = driver->init(0);
  if (error == CUDA_SUCCESS) error = driver->count(&count);
  machine.has_devices = error == CUDA_SUCCESS && count > 0;
  if (error != CUDA_SUCCESS && error != CUDA_ERROR_NO_DEVICE) machine.error = driver->text_of(error);
  return machine;
}

// As cudaGetDeviceProperties, of what is used here.
CUresult ask_for(const CudaDriver& driver, int ordinal, cudaDeviceProp& out, int& compute_mode) {
  CUdevice device = 0;
  CUresult error = driver.device(&device, ordinal);
  const auto ask = [&](const auto& call, auto... arguments) {
    if (error == CUDA_SUCCESS) error = call(arguments..., device);
  };
  ask(driver.name, out.name, static_cast<int>(sizeof(out.name)));
  ask(driver.memory, &out.totalGlobalMem);
  ask(driver.uuid, &out.uuid);
  ask(driver.attribute, &out.major, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR);
  ask(driver.attribute, &out.minor, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR);
  ask(driver.attribute, &compute_mode, CU_DEVICE_ATTRIBUTE_COMPUTE_MODE);
  return error;
}

void add_device(const CudaDriver& driver, int ordinal, const CudaMachine& machine, Survey& survey) {
  cudaDeviceProp properties{};
  int compute_mode = CU_COMPUTEMODE_DEFAULT;
  if (const CUresult error = ask_for(driver, ordinal, properties, compute_mode); error != CUDA_SUCCESS) {
    survey.unusable.push_back({cuda_device(ordinal), "", "it does not answer: " + driver.text_of(error)});
    return;
  }
  const Capability capability{properties.major, properties.minor};
  std::string obstacle = device_obstacle(capability, built(), machine);
  if (compute_mode == CU_COMPUTEMODE_PROHIBITED)
    obstacle = "its compute mode is 'prohibited'; nvidia-smi --compute-mode=0 changes it";
  if (!obstacle.empty()) return survey.unusable.push_back({cuda_device(ordinal), properties.name, std::move(obstacle)});
  DeviceInfo info = info_of(ordinal, properties);
  info.capability = to_string(capability);
  info.needs_compilation = kernels_for(capability, built(), machine) == Kernels::kPtx;
  survey.usable.push_back(std::move(info));
}

Survey survey() {
  int count = 0;
  Survey found;
  const std::optional<CudaDriver> driver = CudaDriver::load();
  const CudaMachine machine = machine_of(driver, count);
  if (std::string obstacle = machine_obstacle(machine); !obstacle.empty()) {
    found.unusable.push_back({{}, "", std::move(obstacle), is_absent(machine)});
    return found;
  }
  for (int ordinal = 0; ordinal < count; ++ordinal) add_device(*driver, ordinal, machine, found);
  return found;
}

// Devices are the same for as long as the process lives, and asking for their properties takes milliseconds.
const Survey& surveyed() {
  static const Survey found = survey();
  return found;
}

}  // namespace

std::vector<DeviceInfo> cuda_devices() { return surveyed().usable; }

std::vector<UnusableDevice> unusable_cuda_devices() { return surveyed().unusable; }

std::string why_no_cuda() {
  std::string why;
  if (surveyed().usable.empty())
    for (const UnusableDevice& each : surveyed().unusable) why += (why.empty() ? "" : "; ") + to_string(each);
  return why;
}

void check_cuda_ordinal(int ordinal) {
  const auto& [usable, unusable] = surveyed();
  std::string there;
  for (const DeviceInfo& info : usable) {
    if (info.device.ordinal == ordinal) return;
    there += (there.empty() ? "" : ", ") + std::to_string(info.device.ordinal);
  }
  for (const UnusableDevice& each : unusable)
    if (!each.device || each.device->ordinal == ordinal) throw DeviceError("device: " + to_string(each));
  if (usable.empty()) throw DeviceError("device: " + why_no_cuda());
  throw InvalidInput(
      "device", "device is " + to_string(cuda_device(ordinal)) + ": this machine has " + std::to_string(usable.size()) +
                    (usable.size() == 1 ? " usable CUDA device (" : " usable CUDA devices (") + there + ")");
}

std::optional<int> current_cuda_device() {
  int ordinal = 0;
  if (cudaGetDevice(&ordinal) == cudaSuccess) return ordinal;
  cudaGetLastError();
  return std::nullopt;
}

// Setting a device makes its context, which takes memory there: only where it is another one.
void set_current_cuda_device(int ordinal) {
  if (current_cuda_device() != ordinal) cudaSetDevice(ordinal);
}

void check_cuda_memory(int ordinal, std::span<const std::byte> memory, const std::string& field) {
  for (const std::byte* at : {memory.data(), memory.data() + memory.size() - 1}) {
    cudaPointerAttributes attributes{};
    const cudaError_t error = cudaPointerGetAttributes(&attributes, at);
    if (error != cudaSuccess) cudaGetLastError();
    const bool is_device = error == cudaSuccess && attributes.type == cudaMemoryTypeDevice;
    const bool is_managed = error == cudaSuccess && attributes.type == cudaMemoryTypeManaged;
    if (is_managed || (is_device && attributes.device == ordinal)) continue;
    const std::string where = is_device ? to_string(cuda_device(attributes.device)) : "the host";
    throw InvalidInput(field, field + " must lie in memory of " + to_string(cuda_device(ordinal)) + ", but its byte " +
                                  std::to_string(at - memory.data()) + " is in that of " + where);
  }
}

}  // namespace collided
