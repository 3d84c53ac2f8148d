#pragma once
// Device memory of a client, and scenes whose contacts stay in it.

#include <cuda_runtime.h>

#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/cpp/client.hpp"
#include "tests/integration/support/layers.hpp"

namespace collided::test {

inline void check_device(cudaError_t error) {
  if (error != cudaSuccess) throw std::runtime_error(std::string("the client's device: ") + cudaGetErrorString(error));
}

class DeviceMemory {
 public:
  explicit DeviceMemory(uint64_t bytes) : bytes_(bytes) {
    check_device(cudaMalloc(&memory_, bytes));
    check_device(cudaMemset(memory_, 0xcd, bytes));
    check_device(cudaDeviceSynchronize());
  }
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;
  ~DeviceMemory() { cudaFree(memory_); }

  uint64_t bytes() const { return bytes_; }
  std::string handle() const {
    cudaIpcMemHandle_t handle;
    check_device(cudaIpcGetMemHandle(&handle, memory_));
    return {reinterpret_cast<const char*>(&handle), sizeof(handle)};
  }
  void write(uint64_t offset, const std::string& bytes) const {
    check_device(cudaMemcpy(static_cast<char*>(memory_) + offset, bytes.data(), bytes.size(), cudaMemcpyHostToDevice));
    check_device(cudaDeviceSynchronize());
  }
  template <class T>
  std::vector<T> read(const client::DeviceArray& array) const {
    std::vector<T> values(array.bytes / sizeof(T));
    if (!values.empty())
      check_device(cudaMemcpy(values.data(), static_cast<const char*>(memory_) + array.offset, array.bytes,
                              cudaMemcpyDeviceToHost));
    return values;
  }

 private:
  void* memory_ = nullptr;
  uint64_t bytes_;
};

inline constexpr uint32_t kDeviceSide = 24;

/// Two layers of which the upper one falls through the lower one and rises again; both modes, every field of contacts.
inline v1::Scene make_device_scene(client::Client& client) {
  std::vector<std::array<uint32_t, 3>> triangles;
  const auto corners = layer_triangles(kDeviceSide);
  for (size_t i = 0; i < corners.size(); i += 3) triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  const client::MeshInput mesh{.name = "layers", .vertex_count = 2 * kDeviceSide * kDeviceSide, .triangles = triangles};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_DCD_AND_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F32);
  spec.set_thickness(0.5 / kDeviceSide);
  for (int field = v1::ContactField_MIN + 1; field <= v1::ContactField_MAX; ++field)
    if (v1::ContactField_IsValid(field) && field != v1::CONTACT_FIELD_PAIR_STATES)  // those are of solids
      spec.add_fields(static_cast<v1::ContactField>(field));
  return client.create_scene(spec, {&mesh, 1});
}

/// Positions differ from frame to frame.
inline std::string device_layers_at(uint64_t id) {
  const double height = kLayerGap * static_cast<double>(1 + id % 3);
  return pack_points(layer_points(kDeviceSide, id % 2 == 0 ? -height : height));
}

}  // namespace collided::test
