#pragma once
// A scene's specification and a frame, from C to the engine. Which options go together is the engine's business.

#include "client/c/calls.hpp"

namespace collided::c {

struct Spec {
  SceneSpec engine;
  FieldSet fields;  ///< that results show
  bool stencils = false;
};

/// Throws InvalidInput, Unimplemented.
Spec parse_spec(const collided_scene_spec* from);

/// The frame borrows the caller's arrays. Throws InvalidInput, Unimplemented.
FrameInput parse_frame(const collided_frame* from);

/// The enumerator of C for the engine that found a frame's pairs.
int32_t enumerator_of(Engine engine);

}  // namespace collided::c
