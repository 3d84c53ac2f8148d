#pragma once
// A scene and its frames as JSON, under the protocol's names; milliseconds end in _ms.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/cpp/frame_stream.hpp"
#include "collided/v1/scene.pb.h"

namespace collided::cli {

using Json = nlohmann::ordered_json;

/// In one line. Bytes that are not UTF-8, as names of files may have, are replaced.
std::string json_text(const Json& json);
/// The same as the lines of a file, indented, with an end of line.
std::string json_lines(const Json& json);
Json scene_json(const v1::Scene& scene);
/// Ids of the devices of a scene's shards, in order.
Json part_devices_json(const v1::SceneSpec& spec);
/// Milliseconds of each stage by name, in their order; a stage that ran twice is summed.
Json stages_json(const v1::FrameMetrics& metrics);
Json counts_json(const v1::FrameCounts& counts);
/// What a frame cost, and the work that it was.
Json frame_json(const v1::FrameDone& done, v1::Report report);
/// "vertex_triangle" and so on.
std::string long_name_of(v1::ContactKind kind);
/// "elements" and so on.
std::string long_name_of(v1::ContactField field);
/// "contacts_vertex_triangle" and so on.
Json contact_counts_json(const client::PerKind<uint64_t>& counts);
/// Sets the numbers of contacts to null: REPORT_ANY_HIT only finds out whether there is one.
void clear_contact_counts(Json& counts);
/// The transport of a stream and, if the daemon offers shared memory that it does not use, why not.
Json transport_json(const client::FrameStream& stream);
/// The warnings of all frames, each once.
Json warnings_json(const std::vector<v1::FrameMetrics>& frames);

}  // namespace collided::cli
