#include "gpu/detector.hpp"

#include "gpu/backends.hpp"
#include "gpu/frame_check.hpp"

namespace collided {

std::unique_ptr<Detector> Detector::create(SceneSpec spec) {
  check_spec(spec);
  FeatureTables features = make_features(spec.meshes);
  return spec.backend == Backend::kCuda ? make_cuda_detector(std::move(spec), std::move(features))
                                        : make_cpu_detector(std::move(spec), std::move(features));
}

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> devices{cpu_device()};
  for (DeviceInfo& device : cuda_devices()) devices.push_back(std::move(device));
  return devices;
}

bool cuda_available() { return !cuda_devices().empty(); }

}  // namespace collided
