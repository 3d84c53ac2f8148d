#pragma once
// The kinds of contacts that there are, and what an answer tells of each contact. A kind or a field is one row here;
// what treats all of them alike goes over the rows.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

namespace collided {

/// Which two features touch, in the order in which answers have them.
enum class ContactKind { kVertexTriangle, kEdgeEdge, kTriangleTriangle, kEdgeTriangle, kVertexSolid };
inline constexpr size_t kContactKinds = 5;

/// One value for each kind.
template <class T>
struct PerKind {
  T vertex_triangle{}, edge_edge{}, triangle_triangle{}, edge_triangle{}, vertex_solid{};

  bool operator==(const PerKind&) const = default;
};

/// visit(kind, value of each of `structs`) for each kind in order.
template <class Visit, class... PerKinds>
constexpr void for_each_kind(const Visit& visit, PerKinds&&... structs) {
  visit(ContactKind::kVertexTriangle, structs.vertex_triangle...);
  visit(ContactKind::kEdgeEdge, structs.edge_edge...);
  visit(ContactKind::kTriangleTriangle, structs.triangle_triangle...);
  visit(ContactKind::kEdgeTriangle, structs.edge_triangle...);
  visit(ContactKind::kVertexSolid, structs.vertex_solid...);
}

/// The value of one kind, of a PerKind.
template <class Values>
constexpr auto& value_of(Values& values, ContactKind kind) {
  auto* found = &values.vertex_triangle;
  for_each_kind([&](ContactKind other, auto& value) { found = other == kind ? &value : found; }, values);
  return *found;
}

/// x, y, z.
using Normal = std::array<float, 3>;

/// What an answer can tell of a contact.
enum class ContactField { kElements, kToi, kDistance, kWeights, kNormals, kFlags, kFeatures, kSignedDistance };

/// One array for each field; its values are those of the wire: little-endian, packed.
template <template <class> class Array>
struct PerField {
  Array<std::array<uint32_t, 2>> elements;  ///< vertex or edge, triangle; or two edges or triangles (first < second)
  Array<double> toi;                        ///< [0, 1]; CCD from kFast on
  Array<double> distance;                   ///< >= 0, but of vertices in solids < 0; from kFast on
  Array<std::array<double, 2>> weights;     ///< triangle's 2nd and 3rd corner, or along each of two edges; if asked for
  Array<Normal> normals;                    ///< unit, as narrow/normal.hpp defines it; if asked for
  Array<uint8_t> flags;                     ///< ContactFlags; from kFast on
  Array<uint8_t> features;                  ///< FeatureBits; of kinds of features in DCD, if asked for
  /// Of the same contacts, if asked for. It is minus `distance` where one closest point is inside the other feature's
  /// mesh, a solid, and else `distance`. It is NaN if neither mesh is a solid, and if both are one mesh. It is NaN,
  /// too, if `distance` is above 0 and one feature meets the other's mesh: such a feature may have points on both
  /// sides.
  Array<double> signed_distance;
};

/// visit(field, array of each of `structs`) for each field in order.
template <class Visit, class... PerFields>
constexpr void for_each_field(const Visit& visit, PerFields&&... structs) {
  visit(ContactField::kElements, structs.elements...);
  visit(ContactField::kToi, structs.toi...);
  visit(ContactField::kDistance, structs.distance...);
  visit(ContactField::kWeights, structs.weights...);
  visit(ContactField::kNormals, structs.normals...);
  visit(ContactField::kFlags, structs.flags...);
  visit(ContactField::kFeatures, structs.features...);
  visit(ContactField::kSignedDistance, structs.signed_distance...);
}

namespace detail {
template <class T>
struct SizeOf {
  size_t bytes = sizeof(T);
};
}  // namespace detail

class FieldSet {
 public:
  constexpr FieldSet() = default;
  constexpr FieldSet(std::initializer_list<ContactField> fields) {
    for (const ContactField field : fields) bits_ |= bit(field);
  }

  constexpr bool has(ContactField field) const { return (bits_ & bit(field)) != 0; }
  constexpr FieldSet with(ContactField field) const { return FieldSet(bits_ | bit(field)); }
  constexpr FieldSet without(ContactField field) const { return FieldSet(bits_ & ~bit(field)); }
  constexpr FieldSet operator|(FieldSet other) const { return FieldSet(bits_ | other.bits_); }
  constexpr FieldSet operator&(FieldSet other) const { return FieldSet(bits_ & other.bits_); }

  constexpr bool operator==(const FieldSet&) const = default;

 private:
  constexpr explicit FieldSet(uint32_t bits) : bits_(bits) {}
  static constexpr uint32_t bit(ContactField field) { return 1u << static_cast<int>(field); }

  uint32_t bits_ = 0;
};

/// Bytes of one contact in arrays of these fields.
constexpr size_t contact_bytes(FieldSet fields) {
  size_t bytes = 0;
  for_each_field([&](ContactField field, auto type) { bytes += fields.has(field) ? type.bytes : 0; },
                 PerField<detail::SizeOf>{});
  return bytes;
}

/// kFlagCertified: certain in real arithmetic; kFlagNear: certain only to within delta and the working precision;
/// kFlagCapped: the limit of iterations was met; kFlagInitial: in contact at t = 0 (with kFlagNear, to within delta);
/// kFlagSeparating: in contact at t = 0 at a distance above 0, and certain to come no closer in the step than
/// 1 - kLostAtRest of it (narrow/separating.hpp); kFlagTouching: of an edge that goes through a triangle, that real
/// arithmetic has a tie, and that whether it does follows from the order of their vertices' ids (exact/crossings.hpp);
/// kFlagCovered: of a contact with `features`, that another one tells the same or is nearer (narrow/covering.hpp).
enum ContactFlags : uint8_t {
  kFlagCertified = 1,
  kFlagNear = 2,
  kFlagCapped = 4,
  kFlagInitial = 8,
  kFlagSeparating = 16,
  kFlagCovered = 32,
  kFlagTouching = 64
};

/// Masks of a contact's `features`. kOfTriangle tells where the closest point of a triangle is: 0 on its face, 1 to 3
/// on the side opposite this corner, 4 to 6 on a corner. kOfFirstEdge and kOfSecondEdge tell it of two edges: 0 inside,
/// 1 and 2 at an end. kNearerAtFirst and kNearerAtSecond: beside the closest point, the surface of this feature's mesh
/// comes clearly nearer. kSameAsBefore: an earlier contact, in the order of answers, is between the same features, as
/// these bits name them.
enum FeatureBits : uint8_t {
  kOfTriangle = 7,
  kOfFirstEdge = 3,
  kOfSecondEdge = 12,
  kNearerAtFirst = 16,
  kNearerAtSecond = 32,
  kSameAsBefore = 64
};

/// Values of a result, in memory that all copies share.
template <class T>
class Column {
 public:
  Column() = default;
  /// `values` keeps the memory that they lie in.
  Column(std::shared_ptr<T> values, size_t size) : values_(std::move(values)), size_(size) {}
  Column(std::vector<T> values) : size_(values.size()) {
    const auto owner = std::make_shared<std::vector<T>>(std::move(values));
    values_ = std::shared_ptr<T>(owner, owner->data());
  }
  Column(std::initializer_list<T> values) : Column(std::vector<T>(values)) {}

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* data() { return values_.get(); }
  const T* data() const { return values_.get(); }
  T& operator[](size_t i) { return values_.get()[i]; }
  const T& operator[](size_t i) const { return values_.get()[i]; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  /// Only the first `size` of them stay.
  void truncate(size_t size) { size_ = std::min(size_, size); }
  /// All but the first `count` of them, at most all, stay.
  void skip(size_t count) {
    if (count > 0) values_ = std::shared_ptr<T>(values_, data() + count);
    size_ -= count;
  }

  bool operator==(const Column& other) const { return std::equal(begin(), end(), other.begin(), other.end()); }

 private:
  std::shared_ptr<T> values_;
  size_t size_ = 0;
};

/// Contacts of one kind, sorted by (first id, second id). Columns that the level does not compute are empty.
struct ContactSet : PerField<Column> {
  size_t size() const { return elements.size(); }
};

/// An array of contacts in memory that a frame names; no bytes: there is none.
struct ArrayRange {
  uint64_t offset = 0, bytes = 0;
};
template <class>
using RangeOf = ArrayRange;

/// Where contacts of one kind lie in a ContactRoom.
struct PlacedContacts : PerField<RangeOf> {
  uint64_t count = 0;
  ArrayRange stencils;
};

/// Of all kinds.
inline size_t count_contacts(const PerKind<ContactSet>& contacts) {
  size_t count = 0;
  for_each_kind([&](ContactKind, const ContactSet& set) { count += set.size(); }, contacts);
  return count;
}

}  // namespace collided
