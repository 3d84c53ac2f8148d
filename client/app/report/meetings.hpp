#pragma once
// Pairs of features that go through each other or touch, in words and as JSON.

#include <string>

#include "client/app/output/contact_points.hpp"
#include "client/app/report/json.hpp"

namespace collided::cli {

/// Pairs of features in DCD at a contact distance of 0.
struct MeetingCounts {
  uint64_t crossing = 0;  ///< of an edge and a triangle that it goes through
  uint64_t touching = 0;  ///< vertex-triangle, edge-edge, and edge-triangle with the flag TOUCHING

  bool is_empty() const { return crossing == 0 && touching == 0; }
  void add(v1::ContactKind kind, const client::Contacts& contacts, size_t i);
};

/// Contacts that a JSON list has at most; counts tell of all.
constexpr size_t kMaxListed = 1000;

/// Returns "2 edges go through triangles, 1 pair touches". Counts of 0 are left out.
std::string meetings_text(const MeetingCounts& counts);

/// `crossing_count` and `touching_count`.
Json meeting_counts_json(const MeetingCounts& counts);

/// A frame of DCD, and how its features are named. All are borrowed.
struct MeetingPlace {
  std::span<const client::MeshInput> meshes;
  const client::SceneFeatures& scene;
  client::Positions positions;  ///< of all vertices
};

/// "edge 12-40 through triangle 7 at (1, 0.5, 2)", with ids counted within meshes, which are named if they are two. The
/// contact is none of two triangles, and has elements, weights, flags and, unless it is edge-triangle, a stencil.
std::string meeting_text(v1::ContactKind kind, const client::Contacts& contacts, size_t i, const MeetingPlace& place);

/// The contact with scene-wide ids, its `point`, and, of the kind edge-triangle, the vertices of its `edge`.
Json meeting_json(v1::ContactKind kind, const client::Contacts& contacts, size_t i, const MeetingPlace& place);

}  // namespace collided::cli
