#pragma once
// Contacts as they leave the backend: an array for each of their values, in the types of the wire.

#include "gpu/contacts/keys.hpp"
#include "gpu/contacts/kinds.hpp"
#include "gpu/exec/buffer.hpp"

namespace collided {

struct IdPair {
  uint32_t first, second;
};
struct WeightPair {
  double first, second;
};

/// Those of a list's values that are wanted.
struct ColumnsWanted {
  bool flags = false, distance = false, toi = false, weights = false;

  bool operator==(const ColumnsWanted&) const = default;
};

/// Contacts of all kinds. Columns that are not wanted are empty.
struct ContactColumns {
  Span<IdPair> elements;
  Span<double> toi, distance;
  Span<WeightPair> weights;
  Span<uint8_t> flags;

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
  FeatureRanks ranks;
  ContactColumns columns;

  /// Whether contacts have more than their keys.
  COLLIDED_HD bool has_data() const { return !data.empty(); }
  /// `from`: its place in the list; no matter if there are only keys.
  COLLIDED_HD void operator()(uint64_t place, uint64_t key, uint64_t from) const {
    const uint32_t rank = first_id(key);
    columns.elements[place] = {rank - ranks.first_of_kind(rank), second_id(key)};
    if (has_data()) columns.put(place, data[from]);
  }
};

template <Executor Exec>
struct ColumnBuffers {
  explicit ColumnBuffers(Exec& exec)
      : elements(exec, "keys"),
        toi(exec, "contacts"),
        distance(exec, "contacts"),
        weights(exec, "contacts"),
        flags(exec, "contacts") {}

  void reserve(uint64_t count, const ColumnsWanted& wanted) {
    elements.allocate(count);
    if (wanted.toi) toi.allocate(count);
    if (wanted.distance) distance.allocate(count);
    if (wanted.weights) weights.allocate(count);
    if (wanted.flags) flags.allocate(count);
  }
  ContactColumns columns(const ColumnsWanted& wanted) const {
    ContactColumns out{elements.all(), {}, {}, {}, {}};
    if (wanted.toi) out.toi = toi.all();
    if (wanted.distance) out.distance = distance.all();
    if (wanted.weights) out.weights = weights.all();
    if (wanted.flags) out.flags = flags.all();
    return out;
  }

  Buffer<IdPair, Exec> elements;
  Buffer<double, Exec> toi, distance;
  Buffer<WeightPair, Exec> weights;
  Buffer<uint8_t, Exec> flags;
};

}  // namespace collided
