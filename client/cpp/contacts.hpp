#pragma once
// The contacts of one kind of one frame, assembled from the daemon's chunks.

#include <array>
#include <cstdint>
#include <vector>

#include "collided/v1/contact.pb.h"
#include "collided/v1/scene.pb.h"

namespace collided::client {

class FrameTransport;

/// Each array has one entry per contact, or is empty if it was not requested or not computed.
struct Contacts {
  uint64_t count = 0;
  std::vector<std::array<uint32_t, 2>> elements;  ///< the two features, by ids of the whole scene
  std::vector<std::array<uint32_t, 4>> stencils;  ///< their vertices
  std::vector<double> toi;                        ///< fraction of the step, 0 to 1
  std::vector<double> distance;                ///< in the unit of the positions; of vertices in solids minus the depth
  std::vector<std::array<double, 2>> weights;  ///< of the triangle's second and third corner, or along both edges
  std::vector<std::array<float, 3>> normals;   ///< unit, from the second feature to the first
  std::vector<uint8_t> flags;                  ///< masks of v1::ContactFlag
  std::vector<uint8_t> features;               ///< masks of ClosestFeatures; in discrete frames alone
  /// Of discrete frames of scenes with a solid: minus `distance` where a closest point is inside the other mesh; NaN
  /// where neither mesh is a solid, and where one of two features at a distance above 0 meets the other mesh.
  std::vector<double> signed_distances;
  std::vector<uint32_t> worlds;  ///< in a stream of a set: each contact's world, ascending
};

/// Lists the masks of Contacts::features. The closest points are p, of the first feature, and q, of the second. Ties go
/// to the feature of the lowest dimension.
enum ClosestFeatures : uint8_t {
  /// Locates q on the triangle of a vertex and a triangle: 0 is the face, 1 to 3 is the side opposite to this corner,
  /// and 4 to 6 is a corner. The three corners are those of the stencil, in its order.
  kOnTriangle = 7,
  kOnFirstEdge = 3,      ///< locates p on the first of two edges: 0 is inside, 1 and 2 are its ends in the stencil
  kOnSecondEdge = 12,    ///< locates q on the second edge: 0 is inside, 4 and 8 are its ends
  kNearerAtFirst = 16,   ///< the first feature's surface comes clearly nearer beside p
  kNearerAtSecond = 32,  ///< the second feature's surface comes clearly nearer beside q
  kSameAsBefore = 64  ///< an earlier contact is between the same two features; vertex-triangle comes before edge-edge
};

/// visit(field, member of Contacts) for each array that a scene can ask for, in the order of v1::ContactField.
template <class Visit>
constexpr void for_each_column(const Visit& visit) {
  visit(v1::CONTACT_FIELD_ELEMENTS, &Contacts::elements);
  visit(v1::CONTACT_FIELD_STENCIL, &Contacts::stencils);
  visit(v1::CONTACT_FIELD_TOI, &Contacts::toi);
  visit(v1::CONTACT_FIELD_DISTANCE, &Contacts::distance);
  visit(v1::CONTACT_FIELD_WEIGHTS, &Contacts::weights);
  visit(v1::CONTACT_FIELD_NORMAL, &Contacts::normals);
  visit(v1::CONTACT_FIELD_FLAGS, &Contacts::flags);
  visit(v1::CONTACT_FIELD_FEATURES, &Contacts::features);
  visit(v1::CONTACT_FIELD_SIGNED_DISTANCE, &Contacts::signed_distances);
}

/// The number of these arrays.
constexpr int kColumnCount = [] {
  int count = 0;
  for_each_column([&](v1::ContactField, auto) { ++count; });
  return count;
}();

/// An array in memory of the device: so many bytes, `offset` bytes from the start of that memory. No bytes: there is
/// none.
struct DeviceArray {
  uint64_t offset = 0, bytes = 0;
};

/// Contacts that stay on the device (LocalOptions::output_cuda_ipc_handle). The types of the arrays are those of
/// Contacts.
struct DeviceContacts {
  uint64_t count = 0;
  DeviceArray elements, stencils, toi, distance, weights, normals, flags, features, signed_distances;
};

/// One value for each kind of contact.
template <class T>
struct PerKind {
  T vertex_triangle{}, edge_edge{}, triangle_triangle{}, edge_triangle{}, vertex_solid{};
};

/// visit(kind, value of each of `structs`) for each kind, in the order of answers.
template <class Visit, class... PerKinds>
void for_each_kind(const Visit& visit, PerKinds&&... structs) {
  visit(v1::CONTACT_KIND_VERTEX_TRIANGLE, structs.vertex_triangle...);
  visit(v1::CONTACT_KIND_EDGE_EDGE, structs.edge_edge...);
  visit(v1::CONTACT_KIND_TRIANGLE_TRIANGLE, structs.triangle_triangle...);
  visit(v1::CONTACT_KIND_EDGE_TRIANGLE, structs.edge_triangle...);
  visit(v1::CONTACT_KIND_VERTEX_SOLID, structs.vertex_solid...);
}

/// Returns the contacts that no other contact covers (v1::CONTACT_FLAG_COVERED), in their order, with their columns.
/// All are kept if the scene does not ask for v1::CONTACT_FIELD_FEATURES and v1::CONTACT_FIELD_FLAGS.
Contacts kept(const Contacts& contacts);

/// What the second feature of a vertex-triangle contact is.
enum class ElementKind { kTriangle, kEdge, kPoint };

/// `stencil`: of a vertex-triangle contact. A loose edge a b is there as a b b, a loose point a as a a a.
constexpr ElementKind element_kind(const std::array<uint32_t, 4>& stencil) {
  if (stencil[2] != stencil[3]) return ElementKind::kTriangle;
  return stencil[1] != stencil[2] ? ElementKind::kEdge : ElementKind::kPoint;
}

/// Appends a chunk; arrays in shared memory are read through `transport`, if there is one. Throws Error (DATA_LOSS) if
/// the length of an array is not the chunk's `count`, for a count that no array confirms, and for a time or a distance
/// that is none.
void append(Contacts& contacts, const v1::ContactChunk& chunk, const FrameTransport* transport = nullptr);

/// The numbers of vertices, elements and meshes of a scene.
struct SceneSize {
  uint64_t vertices = 0, elements = 0, meshes = 0;
};

/// Returns the size of a scene of this spec; 0 if the spec has no meshes.
SceneSize size_of(const v1::SceneSpec& spec);

/// Throws Error (DATA_LOSS) if a contact from the `first` on names a vertex, edge or element that the scene has not.
void check_ids(v1::ContactKind kind, const Contacts& contacts, uint64_t first, const SceneSize& size);

/// Where a chunk's arrays lie in an output region of `bytes` on the device. Throws Error (DATA_LOSS) if an array has
/// not the length that `count` asks for, or does not lie in the region.
DeviceContacts on_device(const v1::ContactChunk& chunk, uint64_t bytes);

}  // namespace collided::client
