#pragma once
// The kinds of contacts as the protocol has them: a kind is one row in kinds.cpp.

#include "collided/v1/collision_service.pb.h"
#include "collided/v1/contact.pb.h"
#include "collided/v1/metrics.pb.h"
#include "collided/v1/scene.pb.h"
#include "gpu/detector.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Sets the kinds that the scene asks for; the engine's own if it asks for none. Throws InvalidInput.
void parse_kinds(const pb::SceneSpec& spec, SceneSpec& engine);
void fill_kinds(const SceneSpec& engine, pb::SceneSpec* out);

pb::ContactKind to_message(ContactKind kind);

/// Candidates, survivors and contacts of each kind, where the protocol counts them.
void fill_counts_of_kinds(const FrameCounts& counts, pb::FrameCounts* out);
/// Bytes of one contact of each kind.
void fill_bytes_of_kinds(const PerKind<uint32_t>& bytes, pb::ContactBytes* out);

}  // namespace collided::server
