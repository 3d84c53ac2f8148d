#pragma once
// Judges whether a mesh is free of self-intersection.

#include <optional>
#include <string>
#include <vector>

#include "client/app/options/values.hpp"
#include "client/app/report/meetings.hpp"

namespace collided::cli {

/// The verdict on a mesh and itself, in real arithmetic on its positions. A mesh of triangles with area, none listed
/// twice, is free of self-intersection if and only if DCD at thickness 0 and EXACT has no contact of the kinds
/// edge-triangle, vertex-triangle and edge-edge.
struct SelfIntersection {
  std::string mesh;
  MeetingCounts counts;
  std::string first;                   ///< in words; empty if there is none
  Json listed = Json::array();         ///< the first kMaxListed
  std::vector<std::string> uncovered;  ///< parts that this says nothing of

  bool is_free() const { return counts.is_empty() && uncovered.empty(); }
};

/// True if a frame of a scene of this spec, with this mesh alone, tells whether the mesh is free of self-intersection.
bool tells_self_intersection(const v1::SceneSpec& spec, const client::MeshInput& mesh);

/// The detection options of such a scene.
DetectionOptions self_detection();

/// Judges the mesh of such a scene by its frame. `positions` are those of the frame, and are what was sent, to the bit.
SelfIntersection judge_self(const client::MeshInput& mesh, client::Positions positions,
                            const client::FrameOutput& output);

/// "body: no self-intersection", or what goes through what, and what is not covered.
std::string self_text(const SelfIntersection& self);
Json self_json(const SelfIntersection& self);

}  // namespace collided::cli
