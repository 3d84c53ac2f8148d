#pragma once
// Where contacts are: the closest points of their two features, at the time of the contact.

#include <optional>

#include "client/cpp/contours.hpp"
#include "client/cpp/frame_stream.hpp"

namespace collided::cli {

/// Positions of all vertices of a scene, at both ends of a step.
struct StepPositions {
  client::Positions start, end;                  ///< DCD has no start
  const client::SceneFeatures* scene = nullptr;  ///< borrowed; without it edge-triangle contacts have no points
};

struct ContactPoints {
  std::array<double, 3> first{}, second{};
};

/// Returns the points of contact `i`, by the formula of proto/CONVENTIONS.md; of an edge-triangle contact both are the
/// same. Returns nothing if its weights were not computed. Throws as client::checked_id() for ids that the scene does
/// not have.
std::optional<ContactPoints> contact_points(v1::ContactKind kind, const client::Contacts& contacts, size_t i,
                                            const StepPositions& positions);

bool asks_for(const v1::SceneSpec& spec, v1::ContactKind kind);
/// True if the spec asks for edge-triangle contacts, whose points need the features of the scene.
bool asks_for_crossings(const v1::SceneSpec& spec);

}  // namespace collided::cli
