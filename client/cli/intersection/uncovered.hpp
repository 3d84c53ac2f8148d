#pragma once
// Parts of a mesh of which no contact tells whether they meet each other.

#include <array>
#include <string>
#include <vector>

#include "client/cpp/client.hpp"
#include "client/cpp/positions.hpp"

namespace collided::cli {

/// True if the corners are not on one line, decided in exact arithmetic. They are finite.
bool has_area(const std::array<double, 3>& a, const std::array<double, 3>& b, const std::array<double, 3>& c);

/// Returns a sentence for each kind of part that keeps a mesh without contacts from being free of self-intersection
/// (proto/CONVENTIONS.md, "Crossings"): triangles without area, triangles listed twice, and loose elements. Triangles
/// are numbered within the mesh. `positions` are those of the mesh's vertices.
std::vector<std::string> uncovered_parts(const client::MeshInput& mesh, client::Positions positions);

}  // namespace collided::cli
