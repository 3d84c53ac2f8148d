#include "gpu/scene/cpu_detector.hpp"

namespace collided {

template std::unique_ptr<Detector> make_cpu_detector_of<double>(SceneSpec spec, FeatureTables features,
                                                                const ShardOf* shard);

}  // namespace collided
