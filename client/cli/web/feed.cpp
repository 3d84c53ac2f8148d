// Watches a scene and shows its frames on the page.

#include "client/cli/web/feed.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/app/options/usage_error.hpp"
#include "client/app/report/text.hpp"

namespace collided::cli {

namespace {

constexpr std::chrono::milliseconds kRetryPause(500);

client::WatchOptions watch_options(const FeedOptions& options, const v1::SceneSpec& spec) {
  client::WatchOptions out;
  out.max_frames_per_second = options.max_frames_per_second;
  out.max_contacts_per_kind = options.max_contacts_per_kind;
  for (int mesh = 0; mesh < spec.meshes_size(); ++mesh)
    if (spec.meshes(mesh).vertex_count() > 0) out.meshes.push_back(static_cast<uint32_t>(mesh));
  return out;
}

bool is_gone(const client::Error& error) { return error.code() == grpc::NOT_FOUND; }

}  // namespace

std::string only_scene(client::Client& client) {
  const std::vector<v1::Scene> scenes = client.list_scenes();
  if (scenes.size() < 2) return scenes.empty() ? "" : scenes[0].scene_id();
  constexpr size_t kNamed = 8;
  std::string names;
  for (size_t i = 0; i < std::min(scenes.size(), kNamed); ++i)
    names += (i ? ", " : "") + scenes[i].scene_id() + " (" + shown_name(scenes[i].spec().display_name()) + ")";
  if (scenes.size() > kNamed) names += " and " + std::to_string(scenes.size() - kNamed) + " more";
  throw UsageError("the daemon has " + std::to_string(scenes.size()) + " scenes; name the one to view: " + names);
}

Feed::Feed(client::Client& client, PageServer& page, FeedOptions options)
    : client_(client), page_(page), options_(std::move(options)) {}

std::string Feed::find_scene() {
  if (!options_.scene_id.empty()) return options_.scene_id;
  for (const v1::Scene& scene : client_.list_scenes())
    if (scene.state() == v1::SCENE_STATE_READY) return scene.scene_id();
  return "";
}

/// Opens the watch of all meshes, and reads what they are made of. An edit meanwhile shows in the first frame.
ShownScene Feed::look_at(const std::string& scene_id) {
  ShownScene shown;
  shown.epoch = ++epoch_;
  shown.scene = client_.get_scene(scene_id);
  client::Watcher watcher = client_.watch(scene_id, watch_options(options_, shown.scene.spec()));
  shown.scene = watcher.scene();
  std::vector<client::MeshElements> meshes;
  for (int mesh = 0; mesh < shown.scene.spec().meshes_size(); ++mesh)
    meshes.push_back(client_.mesh_elements(scene_id, static_cast<uint32_t>(mesh)));
  shown.surface = make_surface(meshes, std::max(1u, watcher.vertex_stride()));
  const std::lock_guard lock(mutex_);
  watcher_ = std::move(watcher);
  return shown;
}

/// Until the scene is edited, or it is told to stop. Throws Error.
void Feed::show_frames(const std::string& scene_id, const std::stop_token& stop) {
  ShownScene shown = look_at(scene_id);
  page_.show_scene(scene_message(shown));
  page_.show_status(status_message("live", ""));
  while (!stop.stop_requested()) {  // from here on it cancels the watcher
    const client::WatchedFrame frame = watcher_->receive();
    if (frame.edit_count != shown.scene.edit_count()) return;
    page_.show_frame(frame_message(shown, frame));
  }
}

void Feed::wait_before_retry(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  stopped_.wait_for(lock, stop, kRetryPause, [] { return false; });
}

/// Tells the page why nothing comes.
bool Feed::may_go_on(const client::Error& error) {
  const bool ends = is_gone(error) && !options_.scene_id.empty();
  if (ends)
    page_.show_status(status_message("ended", "The scene has ended: " + error.message()));
  else if (is_gone(error))
    page_.show_status(status_message("waiting", "The scene has ended. Waiting for another one."));
  else
    page_.show_status(
        status_message("waiting", std::string("Nothing comes from the daemon; trying again. ") + error.what()));
  return !ends;
}

void Feed::run(const std::stop_token& stop) {
  const std::stop_callback cancel(stop, [this] {
    const std::lock_guard lock(mutex_);
    if (watcher_) watcher_->cancel();
  });
  while (!stop.stop_requested()) try {
      const std::string scene_id = find_scene();
      if (!scene_id.empty()) {
        show_frames(scene_id, stop);
        continue;
      }
      if (epoch_ == 0) page_.show_status(status_message("waiting", "The daemon has no scene yet."));
      wait_before_retry(stop);
    } catch (const client::Error& error) {
      if (stop.stop_requested() || !may_go_on(error)) return;
      wait_before_retry(stop);
    }
}

}  // namespace collided::cli
