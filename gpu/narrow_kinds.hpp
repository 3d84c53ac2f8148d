#pragma once
// The kinds of contacts as the narrow phase runs them.

#include "gpu/narrow/contact.hpp"

namespace collided {

/// Names of a kind's stages and places of its results.
struct KindTraits {
  const char *filter, *narrow, *order, *download, *exact;
  ContactSet FrameResult::*contacts;
  uint64_t FrameCounts::*survivors;
  uint64_t FrameCounts::*found;
};
inline constexpr KindTraits kVertexTriangleTraits{"filter_vt",
                                                  "narrow_vt",
                                                  "order_vt",
                                                  "download_vt",
                                                  "exact_vt",
                                                  &FrameResult::vertex_triangle,
                                                  &FrameCounts::survivors_vt,
                                                  &FrameCounts::contacts_vt};
inline constexpr KindTraits kEdgeEdgeTraits{"filter_ee",
                                            "narrow_ee",
                                            "order_ee",
                                            "download_ee",
                                            "exact_ee",
                                            &FrameResult::edge_edge,
                                            &FrameCounts::survivors_ee,
                                            &FrameCounts::contacts_ee};
/// Triangle pairs have no filter.
inline constexpr KindTraits kTrianglePairTraits{nullptr,    "narrow_tt",
                                                "order_tt", "download_tt",
                                                "exact_tt", &FrameResult::triangle_triangle,
                                                nullptr,    &FrameCounts::contacts_tt};

inline const KindTraits& traits_of(const VertexTriangle&) { return kVertexTriangleTraits; }
inline const KindTraits& traits_of(const EdgeEdge&) { return kEdgeEdgeTraits; }

}  // namespace collided
