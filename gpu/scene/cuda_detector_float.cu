#include "gpu/scene/cuda_detector.cuh"

namespace collided {

template std::unique_ptr<Detector> make_cuda_detector_of<float>(SceneSpec spec, FeatureTables features,
                                                                const ShardOf* shard);
template void load_cuda_kernels_of<float>();

}  // namespace collided
