#include "server/refusals/advice.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

namespace collided::server {
namespace {

// What a limit is called in messages, and who raises it how. A name that begins like another comes first.
constexpr std::pair<std::string_view, std::string_view> kRaised[] = {
    {"max_frame_seconds", "the daemon's option --max-frame-seconds, or max-frame-seconds of the client's token"},
    {"spec.memory_budget_bytes", "spec.memory_budget_bytes, up to the daemon's option --max-scene-mb"},
    {"max_device_bytes_per_client",
     "the daemon's option --max-device-mb-per-client, or max-device-mb of the client's token"},
    {"max_device_bytes", "the daemon's option --max-device-mb"}};

std::string found_by_then(const FrameProgress& progress) {
  if (progress.pairs + progress.candidates + progress.contacts == 0) return "";
  return fmt::format(". By then it had found {} pairs of triangles, {} candidates and {} contacts", progress.pairs,
                     progress.candidates, progress.contacts);
}

std::string far_meshes(const FrameProgress& progress, const BusyScene& scene) {
  std::string text;
  for (const auto& [mesh, way, edge] : progress.far_meshes)
    text += fmt::format("{} {} moves by {:.3g} or more, {:.3g} times its mean edge of {:.3g}",
                        text.empty() ? ". In this step" : ",", scene.mesh_name(mesh), way, way / edge, edge);
  if (text.empty()) return text;
  return text + ": all that lies along such a way is tested, so the step costs less in several shorter ones";
}

int count_kinds(const PerKind<bool>& kinds) {
  int count = 0;
  for_each_kind([&](ContactKind, bool is_wanted) { count += is_wanted ? 1 : 0; }, kinds);
  return count;
}

bool has_optional_fields(const FieldSet& fields) {
  const FieldSet always{ContactField::kElements, ContactField::kToi, ContactField::kFlags};
  return (fields | always) != always;
}

bool touches_itself(const MeshSpec& mesh) {
  return mesh.self_contacts && mesh.motion == MeshMotion::kDeformable && (mesh.groups & mesh.collide_mask) != 0;
}

// Returns the switches that could leave out more pairs.
std::vector<std::string> exclusions(const SceneSpec& spec) {
  std::vector<std::string> switches;
  if (spec.meshes.size() > 1) switches.insert(switches.end(), {"groups and collide_mask", "excluded_meshes"});
  if (std::any_of(spec.meshes.begin(), spec.meshes.end(), touches_itself)) switches.push_back("no_self_contacts");
  return switches;
}

// Returns the changes to scene or frame that would make the answer smaller.
std::vector<std::string> smaller_answers(const BusyScene& scene) {
  std::vector<std::string> answers;
  const bool is_all = scene.report() == Report::kAll, has_times = scene.mode() == Mode::kCcd;
  if (scene.report() != Report::kAnyHit && scene.accuracy() >= Accuracy::kFast && scene.spec.worlds == 0)
    answers.push_back(is_all && has_times && scene.accuracy() >= Accuracy::kGuarded ? "report any_hit or earliest_only"
                                                                                    : "report any_hit");
  if (count_kinds(scene.spec.kinds) > 1) answers.push_back("fewer kinds");
  if (scene.report() != Report::kAnyHit && has_optional_fields(scene.spec.fields)) answers.push_back("fewer fields");
  if (const auto switches = exclusions(scene.spec); !switches.empty())
    answers.push_back(fmt::format("meshes that are left out ({})", fmt::join(switches, ", ")));
  if (scene.spec.thickness > 0) answers.push_back("a smaller thickness");
  if (std::ranges::any_of(scene.spec.meshes, [](const MeshSpec& mesh) { return mesh.half_thickness > 0; }))
    answers.push_back("a smaller half_thickness");
  return answers;
}

std::string raised_limit(std::string_view refusal) {
  for (const auto& [limit, option] : kRaised)
    if (refusal.starts_with(limit)) return fmt::format("a higher limit: {}", option);
  return "";
}

std::string what_helps(const std::string& refusal, const BusyScene& scene) {
  const std::string answers = fmt::format("{}", fmt::join(smaller_answers(scene), "; ")), limit = raised_limit(refusal);
  if (answers.empty()) return limit.empty() ? "" : ". What helps is " + limit;
  return ". What takes less: " + answers + (limit.empty() ? "" : "; or " + limit);
}

std::string with_advice(const std::string& refusal, const FrameProgress& progress, const BusyScene& scene) {
  return refusal + found_by_then(progress) + far_meshes(progress, scene) + what_helps(refusal, scene);
}

}  // namespace

LimitExceeded with_advice(const LimitExceeded& refusal, const FrameProgress& progress, const BusyScene& scene) {
  const std::string text = with_advice(std::string(refusal.what()), progress, scene);
  if (refusal.subject().empty()) return {refusal.field(), text};
  return LimitExceeded::quota(refusal.subject(), text, refusal.retry_after_seconds());
}

ResourceExhausted with_advice(const ResourceExhausted& refusal, const FrameProgress& progress, const BusyScene& scene) {
  return ResourceExhausted(with_advice(std::string(refusal.what()), progress, scene));
}

}  // namespace collided::server
