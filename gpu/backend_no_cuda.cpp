#include "gpu/backends.hpp"

namespace collided {

std::unique_ptr<Detector> make_cuda_detector(SceneSpec, FeatureTables) {
  throw DeviceError("backend: this build has no CUDA");
}
std::vector<DeviceInfo> cuda_devices() { return {}; }

}  // namespace collided
