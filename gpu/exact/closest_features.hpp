#pragma once
// On which features the closest points of a contact are, as in real arithmetic. It runs on the host, as the functions
// of exact.hpp do.

#include "gpu/base/vec3.hpp"
#include "gpu/contact_set.hpp"

namespace collided {

/// Returns on which features the closest points of a contact are, as FeatureBits without its upper bits. `points`
/// are the stencil's, v a b c or a0 a1 b0 b1, with any finite coordinates; edges without length and triangles without
/// area are ordinary input. `ids` are the stencil's vertex ids, which break ties of equal dimension; those of a loose
/// edge or point repeat. Not for triangle pairs and crossings.
uint8_t exact_closest_features(ContactKind kind, const Vec3<double> (&points)[4], const uint32_t (&ids)[4]);

}  // namespace collided
