#pragma once
// What is told about a scene and its frames, as JSON. Names are those of the protocol; milliseconds are _ms.

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
/// What a frame cost, and how much there was to do.
Json frame_json(const v1::FrameDone& done, v1::Report report);
/// Whether there is one is all that REPORT_ANY_HIT finds out: the numbers of contacts become null.
void forget_contacts(Json& counts);
/// How a stream's frames travel and, if not through shared memory that the daemon offers, why.
Json transport_json(const client::FrameStream& stream);
/// The warnings of frames, each once.
Json warnings_json(const std::vector<v1::FrameMetrics>& frames);

}  // namespace collided::cli
