#pragma once
// All contacts of a frame that have points, in order.

#include "client/app/output/contact_points.hpp"

namespace collided::cli {

/// A contact and its points.
struct LocatedContact {
  v1::ContactKind kind;
  const client::Contacts& contacts;
  size_t i;
  ContactPoints points;
};

template <class Visit>
void for_each_located(const client::FrameOutput& output, const StepPositions& positions, const Visit& visit) {
  for_each_kind(
      [&](v1::ContactKind kind, const client::Contacts& contacts) {
        for (size_t i = 0; i < contacts.count; ++i)
          if (const auto points = contact_points(kind, contacts, i, positions))
            visit(LocatedContact{kind, contacts, i, *points});
      },
      output);
}

}  // namespace collided::cli
