#pragma once
// Contacts as they leave the backend: an array for each of their values, in the types of the wire.

#include "gpu/base/keys.hpp"
#include "gpu/contacts/kinds.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/exec/concepts.hpp"

namespace collided {

/// Contacts of all kinds. Columns that are not wanted are empty.
struct ContactColumns : PerField<Span> {
  template <class Real>
  COLLIDED_HD void put(uint64_t place, const ContactData<Real>& contact) const {
    if (!flags.empty()) flags[place] = contact.flags;
    if (!distance.empty()) distance[place] = contact.distance;
    if (!toi.empty()) toi[place] = contact.toi;
    if (!weights.empty()) weights[place] = {contact.w0, contact.w1};
  }
};

/// Puts a contact of a list at its place in the columns.
template <class Real>
struct WriteContact {
  Span<const ContactData<Real>> data;  ///< of the list; empty: there are only keys
  Span<const Normal> normals;          ///< of the list; empty if they are not wanted
  FeatureRanks ranks;
  ContactColumns columns;

  /// Whether contacts have more than their keys.
  COLLIDED_HD bool has_data() const { return !data.empty(); }
  /// `from`: its place in the list; no matter if there are only keys.
  COLLIDED_HD void operator()(uint64_t place, uint64_t key, uint64_t from) const {
    const uint32_t rank = first_id(key);
    columns.elements[place] = {rank - ranks.first_of_kind(rank), second_id(key)};
    if (has_data()) columns.put(place, data[from]);
    if (!normals.empty()) columns.normals[place] = normals[from];
  }
};

template <class Exec>
struct BufferOn {
  template <class T>
  using Type = Buffer<T, Exec>;
};

template <Executor Exec>
struct ColumnBuffers : PerField<BufferOn<Exec>::template Type> {
  explicit ColumnBuffers(Exec& exec)
      : PerField<BufferOn<Exec>::template Type>{{exec, "keys"},     {exec, "contacts"}, {exec, "contacts"},
                                                {exec, "contacts"}, {exec, "contacts"}, {exec, "contacts"},
                                                {exec, "contacts"}, {exec, "contacts"}} {}

  void reserve(uint64_t count, FieldSet wanted) {
    for_each_field(
        [&](ContactField field, auto& buffer) {
          if (wanted.has(field)) buffer.allocate(count);
        },
        *this);
  }
  ContactColumns columns(FieldSet wanted) const {
    ContactColumns out;
    for_each_field(
        [&](ContactField field, const auto& buffer, auto& column) {
          if (wanted.has(field)) column = buffer.all();
        },
        *this, out);
    return out;
  }
};

}  // namespace collided
