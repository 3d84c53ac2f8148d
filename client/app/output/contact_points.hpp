#pragma once
// Where contacts are: the closest points of their two features, at the time of the contact.

#include <optional>

#include "client/cpp/frame_stream.hpp"
#include "client/cpp/positions.hpp"

namespace collided::cli {

/// Positions of all vertices of a scene, at both ends of a step.
struct StepPositions {
  client::Positions start, end;  ///< DCD has no start
};

struct ContactPoints {
  std::array<double, 3> first{}, second{};
};

/// `id`, a vertex's or an element's as `what` says. Throws client::Error, DATA_LOSS, unless it is below `count`.
uint32_t checked_id(const char* what, uint32_t id, size_t count);

/// Of contact `i`, by the formula of proto/CONVENTIONS.md. Nothing if its weights were not computed.
/// Throws as checked_id() for a vertex that the scene does not have.
std::optional<ContactPoints> contact_points(v1::ContactKind kind, const client::Contacts& contacts, size_t i,
                                            const StepPositions& positions);

}  // namespace collided::cli
