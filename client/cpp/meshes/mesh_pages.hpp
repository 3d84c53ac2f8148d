#pragma once
// A mesh of a living scene, read in pages.

#include <cstdint>
#include <functional>

#include "client/cpp/client.hpp"

namespace collided::client {

/// The page of a mesh from an element on; throws Error as GetMesh does.
using PageFrom = std::function<v1::GetMeshResponse(uint32_t first_element)>;

/// All pages of a mesh, from the start again if the scene is edited meanwhile. Throws Error: ABORTED if edits keep
/// changing it, DATA_LOSS for pages that do not fit together, and what `page_from` throws.
MeshElements read_elements(uint32_t mesh, const PageFrom& page_from);

}  // namespace collided::client
