#pragma once
// How exactly, how much and by which engine is detected: accuracy levels, tolerances, reports and engines. A scene has
// them, a frame may override all but the engine for itself.

#include <optional>
#include <string>

#include "collided/v1/scene.pb.h"
#include "gpu/detector.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Nothing for an unspecified value. Throws InvalidInput, naming `field`, for an unknown one.
std::optional<Accuracy> parse_accuracy(pb::Accuracy accuracy, const std::string& field);
std::optional<Report> parse_report(pb::Report report, const std::string& field);

/// Throws LimitExceeded, naming `field`, for an accuracy above that which a client may ask for.
void check_most(Accuracy accuracy, Accuracy most, const std::string& field);

/// kAuto for an unspecified value. Throws InvalidInput, naming `field`, for an unknown one.
Engine parse_engine(pb::BroadPhaseEngine engine, const std::string& field);

/// A length that must be finite and at least 0. Throws InvalidInput, naming `field`.
double parse_length(double length, const std::string& field);

pb::Accuracy to_message(Accuracy accuracy);
pb::Report to_message(Report report);
/// kAuto is the unspecified value.
pb::BroadPhaseEngine to_message(Engine engine);

/// Whether mode, accuracy, report and thickness go together, with what the frame overrides (nothing: the scene itself).
/// Throws InvalidInput, naming the field that asks too much: the frame's if it has one.
void check_levels(const SceneSpec& scene, const FrameInput& frame);

}  // namespace collided::server
