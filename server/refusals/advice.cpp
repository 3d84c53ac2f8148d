#include "server/refusals/advice.hpp"

#include <spdlog/fmt/fmt.h>

#include <string_view>
#include <utility>

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

std::string smaller_answers(const BusyScene& scene) {
  const char* earliest = scene.mode == Mode::kDcd ? "" : ", earliest_only in CCD";
  return fmt::format(
      ". What takes less: report any_hit{}; fewer kinds or fields; meshes that are left out (groups and "
      "collide_mask, no_self_contacts, excluded_meshes); a smaller thickness",
      earliest);
}

std::string raised_limit(std::string_view refusal) {
  for (const auto& [limit, option] : kRaised)
    if (refusal.starts_with(limit)) return fmt::format("; or a higher limit: {}", option);
  return "";
}

std::string with_advice(const std::string& refusal, const FrameProgress& progress, const BusyScene& scene) {
  return refusal + found_by_then(progress) + far_meshes(progress, scene) + smaller_answers(scene) +
         raised_limit(refusal);
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
