#pragma once
// How contacts lie in a ContactRoom: the arrays of each kind after those of the kind before.

#include "gpu/base/vec3.hpp"
#include "gpu/contacts/kinds.hpp"

namespace collided {

/// An array for each ContactField in order, then that of the stencils.
COLLIDED_HD constexpr int index_of(ContactField field) { return static_cast<int>(field); }
constexpr int kStencilArray = [] {
  int fields = 0;
  for_each_field([&](ContactField, auto) { ++fields; }, PerField<detail::SizeOf>{});
  return fields;
}();
constexpr int kContactArrays = kStencilArray + 1;

/// Bytes of one contact in each array; 0: there is no such array.
struct ContactWidths {
  uint32_t of[kContactKinds][kContactArrays];

  bool operator==(const ContactWidths&) const = default;
  void set(ContactKind kind, FieldSet fields, bool stencils) {
    uint32_t* const widths = of[index_of(kind)];
    for_each_field(
        [&](ContactField field, auto type) {
          widths[index_of(field)] = fields.has(field) ? static_cast<uint32_t>(type.bytes) : 0;
        },
        PerField<detail::SizeOf>{});
    widths[kStencilArray] = stencils && is_of_features(kind) ? sizeof(Stencil) : 0;
  }
};

/// Contacts of one kind.
struct KindLayout {
  uint64_t begin;               ///< in the list of all kinds
  uint64_t count;               ///< of those that have room, from the first on
  uint64_t at[kContactArrays];  ///< where their arrays begin, in bytes
};

/// The contacts that have room are the first of the list of all kinds.
struct ContactLayout {
  KindLayout kinds[kContactKinds];
  uint64_t count;

  COLLIDED_HD int kind_of(uint64_t i) const {
    int found = 0;
    for (int kind = 1; kind < static_cast<int>(kContactKinds); ++kind)
      if (i >= kinds[kind].begin) found = kind;
    return found;
  }
};

/// The layout of `count` contacts in a room of so many bytes. A kind of which not all have room ends it.
COLLIDED_HD inline ContactLayout lay_out(const ContactWidths& widths, const KindBegins& begins, uint64_t count,
                                         uint64_t room) {
  constexpr uint64_t kAlignment = ContactRoom::kAlignment, kSlack = kContactArrays * kAlignment;
  ContactLayout out = {};
  uint64_t used = 0;
  for (int k = 0; k < static_cast<int>(kContactKinds); ++k) {
    const uint64_t next = k + 1 < static_cast<int>(kContactKinds) ? begins.at[k + 1] : count;
    KindLayout& kind = out.kinds[k];
    kind.begin = min(begins.at[k], count);
    uint64_t bytes = 0;
    for (const uint32_t width : widths.of[k]) bytes += width;
    const uint64_t left = room - used, fit = left < kSlack ? 0 : (left - kSlack) / max(bytes, uint64_t{1});
    if (kind.begin == out.count) kind.count = min(min(next, count) - kind.begin, bytes == 0 ? count : fit);
    for (int a = 0; a < kContactArrays; ++a) {
      kind.at[a] = used;
      used += (kind.count * widths.of[k][a] + kAlignment - 1) / kAlignment * kAlignment;
    }
    out.count += kind.count;
  }
  return out;
}

}  // namespace collided
