#pragma once
// Positions as they go on the wire.

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "client/cpp/frame_advance.hpp"
#include "client/cpp/frame_update.hpp"
#include "collided/v1/frame.pb.h"
#include "collided/v1/scene.pb.h"

namespace collided::client {

/// x, y and z of each vertex, borrowed.
using Positions = std::span<const std::array<double, 3>>;

/// Bytes of one vertex's position: 12 (F32), 24 (F64) or 6 (Q16). Throws Error (INVALID_ARGUMENT) for other formats.
uint64_t position_bytes(v1::PositionFormat format);

/// True if the daemon computes with the positions as doubles, and shows them as such to watchers; false: as floats.
bool is_double(v1::PositionFormat format);

/// True if positions are encoded in the box of the scene's spec, so that most points between two of them have no code.
bool is_quantized(v1::PositionFormat format);

/// Packs as F32 (rounded to nearest) or F64. Throws Error (INVALID_ARGUMENT) for other formats.
std::string pack_positions(Positions positions, v1::PositionFormat format);

/// Packs as Q16, each coordinate to the nearest step of the box. Throws Error (INVALID_ARGUMENT) for a box without
/// three finite coordinates each, or a position that is not in it.
std::string pack_quantized(Positions positions, const v1::QuantizationBox& box);

/// The update of one mesh; `start` (t = 0, for CCD) may be empty. Throws Error as pack_positions().
v1::MeshUpdate mesh_update(uint32_t mesh, v1::PositionFormat format, Positions positions, Positions start = {});
/// The same in the format of the spec, and in its box. Throws Error as pack_positions() and pack_quantized().
v1::MeshUpdate mesh_update(uint32_t mesh, const v1::SceneSpec& spec, Positions positions, Positions start = {});

/// The update that moves a rigid mesh to a pose (t = 1), as FrameUpdate::transform does.
v1::MeshUpdate rigid_update(uint32_t mesh, const RigidMatrix& matrix);
/// The same from another pose (t = 0, CCD) than where the last frame left the mesh.
v1::MeshUpdate rigid_update(uint32_t mesh, const RigidMatrix& matrix, const RigidMatrix& start);

/// Where a pose puts the vertices of a rigid mesh, from where its first frame had them. Every bit is the daemon's;
/// proto/CONVENTIONS.md has the formula. Throws Error (INVALID_ARGUMENT) if coordinates are no multiple of three.
void move_rigidly(std::span<float> positions, const RigidMatrix& matrix);
/// The same in double precision.
void move_rigidly(std::span<double> positions, const RigidMatrix& matrix);

/// The pose of a rigid mesh at a fraction of the way from one pose to another, where an advance ends: the fraction is
/// FrameAdvance::of_body. Every bit is the daemon's, which takes turns of up to 3 radians; proto/CONVENTIONS.md has the
/// formula. Throws Error (INVALID_ARGUMENT) if the fraction is not from 0 to 1, or, between these, if the rotations of
/// the poses are half a turn apart or not finite.
RigidMatrix pose_along(const RigidMatrix& from, const RigidMatrix& to, double fraction);

/// Moves coordinates the fraction of the way to `target` that the daemon moved them: FrameDone.advanced, or a frame's
/// from_last_fraction. Every bit is the daemon's; client/STEPPING.md has the formula. Throws Error (INVALID_ARGUMENT)
/// if there are not as many of one as of the other, or the fraction is not from 0 to 1.
void move_along(std::span<float> positions, std::span<const float> target, double fraction);
/// The same in double precision.
void move_along(std::span<double> positions, std::span<const double> target, double fraction);

/// Moves the coordinates of one mesh to where a frame with `advance`, of any mode, moved them on their way to `target`.
/// Every bit is the daemon's. `first_vertex`: of the mesh, scene-wide. Throws Error (INVALID_ARGUMENT) if there are not
/// as many of one as of the other, or not three for each vertex.
void move_along(std::span<float> positions, std::span<const float> target, const FrameAdvance& advance, uint32_t mesh,
                uint32_t first_vertex);
/// The same in double precision.
void move_along(std::span<double> positions, std::span<const double> target, const FrameAdvance& advance, uint32_t mesh,
                uint32_t first_vertex);

}  // namespace collided::client
