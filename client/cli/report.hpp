#pragma once
// What is told about a scene and its frames, as JSON or as text.

#include <nlohmann/json.hpp>
#include <vector>

#include "client/cpp/frame_stream.hpp"
#include "collided/v1/scene.pb.h"

namespace collided::cli {

using Json = nlohmann::ordered_json;

Json scene_json(const v1::Scene& scene);
/// Stages by name in milliseconds, in their order; a stage that ran twice is summed.
Json stages_json(const v1::FrameMetrics& metrics);
Json counts_json(const v1::FrameCounts& counts);
Json frame_json(const v1::FrameDone& done);
/// The warnings of frames, each once.
Json warnings_json(const std::vector<v1::FrameMetrics>& frames);

/// Medians, over the frames, of every stage and of the total ("total").
Json median_stages(const std::vector<v1::FrameMetrics>& frames);

/// An object as aligned lines "name  value"; nested objects are indented.
void print_text(const Json& object, int indent = 0);

}  // namespace collided::cli
