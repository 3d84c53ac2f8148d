// After an error that a device does not recover from it no longer counts as working, and a scene says so. A program of
// its own, for the process is of no use afterwards. Exit status: 0 passed, 77 there is no device.

#include <array>
#include <cstdio>

#include "gpu/detector.hpp"

namespace {

__global__ void fail_kernel() { __trap(); }

int failures = 0;
void expect(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "not so: %s\n", what);
  ++failures;
}

}  // namespace

int main() {
  using namespace collided;
  if (!cuda_available()) {
    std::puts("skipped: no CUDA device can be used");
    return 77;
  }
  SceneSpec spec;
  spec.device.backend = Backend::kCuda;
  MeshSpec mesh;
  mesh.vertex_count = 3;
  mesh.triangles = {{0, 1, 2}};
  spec.meshes = {mesh};
  const std::array<float, 9> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
  FrameInput frame;
  frame.updates.push_back({0, {}, std::as_bytes(std::span(positions))});
  auto detector = Detector::create(spec);
  const auto slot = detector->make_slot();
  detector->detect(frame);
  expect(device_works({Backend::kCuda}), "the device works at first");

  fail_kernel<<<1, 1>>>();
  cudaDeviceSynchronize();
  expect(!device_works({Backend::kCuda}), "the device has failed");
  expect(!device_works({Backend::kCuda}), "the device has still failed when it is asked again");
  expect(device_works({Backend::kCpu}), "the CPU works");
  try {
    detector->detect(frame);
    expect(false, "a frame on the failed device throws");
  } catch (const DeviceError&) {
  }
  try {
    slot->send(frame.updates);
    expect(false, "positions for the failed device throw");
  } catch (const DeviceError&) {
  }
  return failures == 0 ? 0 : 1;
}
