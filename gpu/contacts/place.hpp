#pragma once
// From the columns of a step to the memory in which a frame's contacts stay.

#include "gpu/base/keys.hpp"
#include "gpu/contacts/columns.hpp"
#include "gpu/contacts/layout.hpp"

namespace collided {

/// Of a list whose length the backend knows.
struct LayOutContacts {
  ContactWidths widths;
  const KindBegins* begins;
  Counted count;
  const Span<std::byte>* room;
  ContactLayout* layout;

  COLLIDED_HD void operator()(uint64_t) const { *layout = lay_out(widths, *begins, count.size(), room->size()); }
};

/// 1 for what is no contact that counts.
struct TimeOfContact {
  ContactColumns columns;
  Counted count;
  bool ignore_separating;

  COLLIDED_HD double operator()(uint64_t i) const {
    if (i >= count.size() || (ignore_separating && (columns.flags[i] & kFlagSeparating) != 0)) return 1;
    return columns.toi[i];
  }
};
struct Earlier {
  COLLIDED_HD double operator()(double a, double b) const { return b < a ? b : a; }
};

/// Puts contact i of the list where the layout says.
struct PlaceContact {
  ContactWidths widths;
  const ContactLayout* layout;
  const Span<std::byte>* room;
  ContactColumns columns;
  FeatureKinds features;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Target to = target_of(i);
    if (to.place >= to.kind->count) return;
    // All columns have a name here, or this does not compile.
    const auto& [elements, toi, distance, weights, normals, flags, closest, with_sign] =
        static_cast<const PerField<Span>&>(columns);
    put(to, index_of(ContactField::kElements), elements, i);
    put(to, index_of(ContactField::kToi), toi, i);
    put(to, index_of(ContactField::kDistance), distance, i);
    put(to, index_of(ContactField::kWeights), weights, i);
    put(to, index_of(ContactField::kNormals), normals, i);
    put(to, index_of(ContactField::kFlags), flags, i);
    put(to, index_of(ContactField::kFeatures), closest, i);
    put(to, index_of(ContactField::kSignedDistance), with_sign, i);
    if (to.widths[kStencilArray] != 0) put_stencil(to, i);
  }

 private:
  struct Target {
    int index;
    const KindLayout* kind;
    const uint32_t* widths;
    uint64_t place;  ///< in the arrays of the kind
  };

  COLLIDED_HD Target target_of(uint64_t i) const {
    const int index = layout->kind_of(i);
    const KindLayout* kind = &layout->kinds[index];
    return {index, kind, widths.of[index], i - kind->begin};
  }
  template <class T>
  COLLIDED_HD T& at(const Target& to, int array) const {
    return reinterpret_cast<T*>(room->data + to.kind->at[array])[to.place];
  }
  template <class T>
  COLLIDED_HD void put(const Target& to, int array, const Span<T>& column, uint64_t i) const {
    if (to.widths[array] != 0) at<T>(to, array) = column[i];
  }
  /// A step that was short of room, and runs again, may have left ids that nobody wrote.
  COLLIDED_HD void put_stencil(const Target& to, uint64_t i) const {
    const uint32_t* ids = reinterpret_cast<const uint32_t*>(columns.elements.data + i);
    const uint64_t key = pack_ids(ids[0], ids[1]);
    features.use_one(to.index, [&](const auto& kind) {
      if (kind.has(key)) at<Stencil>(to, kStencilArray) = kind.stencil(key);
    });
  }
};

}  // namespace collided
