#pragma once
// The detectors of each backend for one scalar. One source file makes each, as each takes a minute or more to compile.

#include "gpu/detector.hpp"
#include "gpu/scene/shards/meeting.hpp"
#include "gpu/tables/topology.hpp"

namespace collided {

/// As make_cpu_detector and make_cuda_detector, for a scene whose scalar is `Real`.
template <class Real>
std::unique_ptr<Detector> make_cpu_detector_of(SceneSpec spec, FeatureTables features, const ShardOf* shard);
template <class Real>
std::unique_ptr<Detector> make_cuda_detector_of(SceneSpec spec, FeatureTables features, const ShardOf* shard);

/// Loads the kernels of that file on a GPU that is in use; where they come as PTX, the driver compiles them first.
template <class Real>
void load_cuda_kernels_of();

}  // namespace collided
