#pragma once
// One scene on several devices: each shard is a scene of its own, with all positions and a share of the pairs.

#include <memory>
#include <vector>

#include "gpu/detector.hpp"
#include "gpu/tables/topology.hpp"

namespace collided {

/// Of a spec with part_devices. Throws as Detector::create does.
std::unique_ptr<Detector> make_sharded_scene(SceneSpec spec, FeatureTables features);

/// Adds what shard `k` holds.
void add_memory(std::vector<MemoryPart>& all, size_t k, const std::vector<MemoryPart>& of_shard);

}  // namespace collided
