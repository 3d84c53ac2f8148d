#pragma once
// A scene's place among KnownLengths.

#include "gpu/types.hpp"

namespace collided {

/// Equal for scenes whose lists, in the same places, are equally long. Reads all elements.
uint64_t hash_of_scene(const SceneSpec& spec, const Topology& topology);

/// Expects what scenes alike needed, beside what the spec does already.
void expect_known_lengths(SceneSpec& spec, const Topology& topology);

}  // namespace collided
