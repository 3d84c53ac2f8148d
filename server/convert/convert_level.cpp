// How exactly, how much and by which engine is detected: accuracy levels, tolerances, reports and engines.
#include "server/convert/convert_level.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "server/convert/refuse.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr std::pair<pb::Accuracy, Accuracy> kAccuracies[] = {{pb::ACCURACY_CANDIDATES, Accuracy::kCandidates},
                                                             {pb::ACCURACY_FAST, Accuracy::kFast},
                                                             {pb::ACCURACY_GUARDED, Accuracy::kGuarded},
                                                             {pb::ACCURACY_CERTIFIED, Accuracy::kCertified},
                                                             {pb::ACCURACY_EXACT, Accuracy::kExact}};

constexpr std::pair<pb::Report, Report> kReports[] = {{pb::REPORT_ALL, Report::kAll},
                                                      {pb::REPORT_EARLIEST_ONLY, Report::kEarliestOnly},
                                                      {pb::REPORT_ANY_HIT, Report::kAnyHit}};

constexpr std::pair<pb::BroadPhaseEngine, Engine> kEngines[] = {
    {pb::BROAD_PHASE_ENGINE_OCTREE, Engine::kOctree},
    {pb::BROAD_PHASE_ENGINE_TOP_DOWN_OCTREE, Engine::kTopDown},
    {pb::BROAD_PHASE_ENGINE_BOTTOM_UP_OCTREE, Engine::kBottomUp},
    {pb::BROAD_PHASE_ENGINE_UNIFORM_GRID, Engine::kUniformGrid},
    {pb::BROAD_PHASE_ENGINE_TWO_LEVEL_GRID, Engine::kTwoLevelGrid},
    {pb::BROAD_PHASE_ENGINE_LBVH, Engine::kLbvh}};

template <class Message, class Value, size_t N>
std::optional<Value> to_engine(const std::pair<Message, Value> (&values)[N], Message wanted, const std::string& field) {
  if (wanted == Message{}) return {};
  for (const auto& [message, value] : values)
    if (message == wanted) return value;
  std::vector<Message> usable;
  for (const auto& [message, value] : values) usable.push_back(message);
  throw_unknown(field, wanted, usable);
}

template <class Message, class Value, size_t N>
Message from_engine(const std::pair<Message, Value> (&values)[N], Value wanted) {
  for (const auto& [message, value] : values)
    if (value == wanted) return message;
  return {};
}

std::string name_of(Accuracy accuracy) { return pb::Accuracy_Name(to_message(accuracy)); }
std::string name_of(Report report) { return pb::Report_Name(to_message(report)); }

// The lowest level that a report can be made from.
Accuracy least_accuracy(Report report) {
  if (report == Report::kEarliestOnly) return Accuracy::kGuarded;
  return report == Report::kAnyHit ? Accuracy::kFast : Accuracy::kCandidates;
}

// A frame's accuracy that is too low for the scene's report is the frame's fault, else the report asks too much.
[[noreturn]] void throw_too_low(Accuracy accuracy, Report report, const FrameInput& frame) {
  const std::string accuracy_field = frame.accuracy ? "frame.accuracy" : "spec.accuracy";
  const std::string report_field = frame.report ? "frame.report" : "spec.report";
  const std::string least = name_of(least_accuracy(report)) + " or above";
  if (frame.accuracy && !frame.report)
    throw_invalid(accuracy_field, fmt::format("is {}, but {} is {}, which needs {}", name_of(accuracy), report_field,
                                              name_of(report), least));
  throw_invalid(report_field, fmt::format("is {}, which needs {}, but {} is {}", name_of(report), least, accuracy_field,
                                          name_of(accuracy)));
}

}  // namespace

std::optional<Accuracy> parse_accuracy(pb::Accuracy accuracy, const std::string& field) {
  return to_engine(kAccuracies, accuracy, field);
}

void check_most(Accuracy accuracy, Accuracy most, const std::string& field) {
  if (accuracy <= most) return;
  throw LimitExceeded(field, fmt::format("{} is {}, above max_accuracy, {}", field, name_of(accuracy), name_of(most)));
}

std::optional<Report> parse_report(pb::Report report, const std::string& field) {
  return to_engine(kReports, report, field);
}

Engine parse_engine(pb::BroadPhaseEngine engine, const std::string& field) {
  return to_engine(kEngines, engine, field).value_or(Engine::kAuto);
}

double parse_length(double length, const std::string& field) {
  if (!std::isfinite(length) || length < 0)
    throw_invalid(field, fmt::format("is {}, but must be finite and at least 0", length));
  return length;
}

pb::Accuracy to_message(Accuracy accuracy) { return from_engine(kAccuracies, accuracy); }
pb::Report to_message(Report report) { return from_engine(kReports, report); }
pb::BroadPhaseEngine to_message(Engine engine) { return from_engine(kEngines, engine); }

void check_levels(const SceneSpec& scene, const FrameInput& frame) {
  const Accuracy accuracy = frame.accuracy.value_or(scene.accuracy);
  const Report report = frame.report.value_or(scene.report);
  const bool by_distance = scene.mode == Mode::kDcd && (scene.vertex_triangle || scene.edge_edge);
  if (report == Report::kEarliestOnly && scene.mode == Mode::kDcd)
    throw_invalid(frame.report ? "frame.report" : "spec.report",
                  "is REPORT_EARLIEST_ONLY, which needs DETECTION_MODE_CCD, but spec.mode is DETECTION_MODE_DCD");
  if (accuracy < least_accuracy(report)) throw_too_low(accuracy, report, frame);
  if (scene.mode == Mode::kCcd && scene.triangle_triangle && accuracy != Accuracy::kCandidates)
    throw_invalid("frame.accuracy", fmt::format("is {}, but CONTACT_KIND_TRIANGLE_TRIANGLE of spec.kinds needs "
                                                "ACCURACY_CANDIDATES with DETECTION_MODE_CCD",
                                                name_of(accuracy)));
  if (by_distance && accuracy == Accuracy::kFast && scene.thickness == 0) {
    if (frame.accuracy)
      throw_invalid("frame.accuracy",
                    "is ACCURACY_FAST, which needs spec.thickness greater than 0 for DCD, but that is 0");
    throw_invalid("spec.thickness", "is 0, but must be greater than 0 for DCD at ACCURACY_FAST");
  }
}

}  // namespace collided::server
