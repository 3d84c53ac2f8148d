#pragma once
// What a few frames of a scene cost on a daemon.

#include <span>

#include "client/app/daemon/connection.hpp"
#include "client/measure/bench/input.hpp"
#include "client/measure/capacity/workload.hpp"

namespace collided::cli {

/// Plays `steps` frames of the input on a scene of its own, one in flight, after as many that do not count. `spec` is
/// without meshes. Throws Interrupted.
Measured measure_scene(Connection& connection, const v1::SceneSpec& spec, std::span<const client::MeshInput> meshes,
                       const BenchInput& input, int steps);

}  // namespace collided::cli
