#pragma once
// What is detected, how exactly, how much of it is reported, by which engine, and how meshes move. A scene has these
// options; a frame may override accuracy, delta and report. Which of them go together is the engine's to say.

#include <optional>
#include <string>
#include <string_view>

#include "collided/v1/frame.pb.h"
#include "collided/v1/metrics.pb.h"
#include "collided/v1/scene.pb.h"
#include "gpu/detector.hpp"
#include "server/scenes/scene/plan.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Throws InvalidInput, naming `field`, for an unspecified or unknown value.
Mode parse_mode(pb::DetectionMode mode, const std::string& field);
pb::DetectionMode to_message(Mode mode);

/// The engine's value: of Accuracy, Report, AdvanceMode, Engine, Reuse and MeshMotion. Nothing for an unspecified one.
/// Throws InvalidInput, naming `field`, for an unknown one.
template <class Value, class Message>
std::optional<Value> parse(Message message, const std::string& field);

/// Throws LimitExceeded, naming `field`, for an accuracy above the highest that a client may ask for.
void check_max_accuracy(Accuracy accuracy, Accuracy max, const std::string& field);

/// The fields that the scene asks for, or those that it gets if it asks for none. Throws InvalidInput.
OutputFields parse_fields(const pb::SceneSpec& spec, Mode mode);

/// The format of the positions; F32 for an unspecified one. Throws InvalidInput for an unknown one, and for a box of
/// encoded positions that is missing or not wanted.
void parse_format(const pb::SceneSpec& spec, SceneSpec& engine);
pb::PositionFormat format_of(const SceneSpec& engine);

pb::Accuracy to_message(Accuracy accuracy);
pb::Report to_message(Report report);
pb::MeshMotion to_message(MeshMotion motion);
/// kAuto is the unspecified value.
pb::BroadPhaseEngine to_message(Engine engine);
pb::BroadPhaseReason to_message(EngineReason reason);
pb::Reuse to_message(Reuse reuse);
pb::ListUse to_message(ListUse use);
pb::ReuseReason to_message(ReuseReason reason);
/// As labels of metrics: "octree", "first_frames". Never allocated anew: every frame asks for both.
std::string_view label_of(Engine engine);
std::string_view label_of(EngineReason reason);
void fill_fields(const OutputFields& fields, pb::SceneSpec* out);

/// The engine's refusal of a scene, with the path of the field of `spec` that it is about.
InvalidInput with_path_in(const InvalidInput& error, const pb::SceneSpec& spec);
/// Throws the engine's refusal of a scene's options, with the path of the field of `spec` that they come from.
void check_scene_options(const SceneSpec& engine, const pb::SceneSpec& spec);
/// The same for what a frame of a sound scene overrides. The field is the frame's.
void check_frame_options(const SceneSpec& scene, const FrameInput& frame);

}  // namespace collided::server
