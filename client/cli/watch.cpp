// collidectl watch: the frames that others send to a scene, as a table that follows them or a line each.

#include <grpcpp/support/status_code_enum.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>

#include "client/app/daemon/connection.hpp"
#include "client/app/daemon/interrupt.hpp"
#include "client/app/options/finite.hpp"
#include "client/app/options/options.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/output.hpp"
#include "client/app/report/digest.hpp"
#include "client/app/report/frame_line.hpp"
#include "client/app/report/numbers.hpp"
#include "client/app/report/text.hpp"
#include "client/cli/commands.hpp"
#include "client/cli/live/live_table.hpp"
#include "client/cli/live/screen.hpp"
#include "client/cli/recording/live.hpp"

namespace collided::cli {

namespace {

struct WatchCommand {
  ServerOptions server;
  std::string scene_id;
  client::WatchOptions watch;
  uint64_t frames = 0;
  std::string record;
  std::vector<std::string> meshes;  ///< files
  bool list = false, table = false, plain = false, json = false;
};

/// Ends the watch after an interrupt, which its thread, waiting for a frame, would not notice.
class EndOnInterrupt {
 public:
  explicit EndOnInterrupt(client::Watcher& watcher)
      : thread_([&watcher](const std::stop_token& stop) {
          constexpr std::chrono::milliseconds kPollInterval(50);
          while (!stop.stop_requested() && !is_interrupted()) std::this_thread::sleep_for(kPollInterval);
          if (is_interrupted()) watcher.cancel();
        }) {}

 private:
  std::jthread thread_;
};

std::string line_of(const WatchCommand& options, const client::WatchedFrame& frame, const v1::SceneSpec& spec) {
  if (!options.json)
    return "frame " + std::to_string(frame.frame_id) + ": " + frame_text(frame.done, spec) + ", " +
           std::to_string(frame.skipped_frames) + " skipped";
  Json line = {{"frame", frame.frame_id}, {"skipped_frames", frame.skipped_frames}};
  line.update(frame_result_json(frame.done, spec));
  // A digest of all contacts, or none.
  if (!options.record.empty() && frame.omitted_contacts == 0) line["contacts_digest"] = digest_of(frame);
  return json_text(line);
}

void check_usage(const WatchCommand& options) {
  if (options.server.server.empty()) throw UsageError("watch needs --server, the daemon that has the scene");
  if (options.list && !options.scene_id.empty()) throw UsageError("--list takes no SCENE");
  if (options.scene_id.empty() && (!options.record.empty() || options.table))
    throw UsageError(std::string(options.table ? "--table" : "--record") +
                     " needs SCENE; without it, watch lists the scenes");
  if (options.table + options.plain + options.json > 1)
    throw UsageError("watch takes one of --table, --plain and --json");
  if (options.table && !has_screen()) throw UsageError("--table needs a terminal as standard output");
  if (options.record.empty()) return;
  if (is_standard_output(options.record)) throw UsageError("--record writes a file; standard output (-) is none");
  if (options.watch.frame_interval > 1 || options.watch.max_frames_per_second > 0)
    throw UsageError("--record needs every frame; --interval and --rate leave some out");
}

void show_lines(const WatchCommand& options, client::Watcher& watcher, const ReceiveFrame& receive) {
  const EndOnInterrupt end(watcher);
  try {
    while (const auto frame = receive()) print_line(line_of(options, *frame, watcher.scene().spec()));
  } catch (const client::Error&) {
    check_interrupt();
    throw;
  }
}

bool is_table(const WatchCommand& options) {
  return options.table || (!options.plain && !options.json && has_screen());
}

/// Frames as they come, recorded if that is wanted.
class Frames {
 public:
  Frames(const WatchCommand& options, Connection& connection)
      : left_(options.frames == 0 ? ~uint64_t{0} : options.frames),
        watcher_(connection->watch(options.scene_id, watch_options(options, connection))) {
    if (!options.record.empty()) recorder_.emplace(options.record, watcher_.scene(), options.meshes);
  }
  client::Watcher& watcher() { return watcher_; }
  /// The next one; nothing after the last, which may be the scene's.
  std::optional<client::WatchedFrame> receive() try {
    if (left_-- == 0) return {};
    client::WatchedFrame frame = watcher_.receive();
    if (recorder_ && !recorder_->add(frame)) return {};
    return frame;
  } catch (const client::Error& e) {
    if (e.code() != grpc::NOT_FOUND) throw;
    check_interrupt();  // which may have ended the scene as well
    return {};
  }
  /// What was recorded can be replayed from now on.
  void finish() {
    if (!recorder_) return;
    recorder_->finish();
    std::fputs(recorder_->summary().c_str(), stderr);
  }

 private:
  static client::WatchOptions watch_options(const WatchCommand& options, Connection& connection) {
    if (options.record.empty()) return options.watch;
    return LiveRecorder::watch_options(connection->get_scene(options.scene_id));
  }

  uint64_t left_;
  client::Watcher watcher_;
  std::optional<LiveRecorder> recorder_;
};

void show(const WatchCommand& options, Frames& frames) {
  const auto receive = [&] { return frames.receive(); };
  client::Watcher& watcher = frames.watcher();
  if (is_table(options))
    show_live(watcher.scene(), receive, [&] { watcher.cancel(); });
  else
    show_lines(options, watcher, receive);
}

std::string scene_text(const v1::Scene& scene) {
  const std::string name = shown_name(scene.spec().display_name());
  return scene.scene_id() + "  " + (name.empty() ? "(no name)" : name) + ", " + count_text(scene.spec().meshes_size()) +
         (scene.spec().meshes_size() == 1 ? " mesh, " : " meshes, ") + count_text(scene.triangle_count()) +
         " triangles, frame " + std::to_string(scene.last_frame_id());
}

Json listed_json(const v1::Scene& scene) {
  return {{"id", scene.scene_id()},
          {"name", shown_name(scene.spec().display_name())},
          {"meshes", scene.spec().meshes_size()},
          {"vertices", scene.vertex_count()},
          {"triangles", scene.triangle_count()},
          {"frame", scene.last_frame_id()}};
}

/// The scenes that can be watched: sets of scenes have no watch.
void list_scenes(const WatchCommand& options) {
  Connection connection(options.server);
  std::vector<v1::Scene> scenes = connection->list_scenes();
  std::erase_if(scenes, [](const v1::Scene& scene) { return scene.worlds() > 0; });
  for (const v1::Scene& scene : scenes) print_line(options.json ? json_text(listed_json(scene)) : scene_text(scene));
  if (scenes.empty() && !options.json) std::fputs("the daemon has no scene that can be watched\n", stderr);
}

void run(const WatchCommand& options) {
  check_usage(options);
  if (options.scene_id.empty()) return list_scenes(options);
  check_writable("--record", options.record);
  defer_interrupts();
  Connection connection(options.server);
  Frames frames(options, connection);
  try {
    show(options, frames);
  } catch (const std::exception&) {
    frames.finish();
    throw;
  }
  frames.finish();
}

}  // namespace

void add_watch(CLI::App& app) {
  auto options = std::make_shared<WatchCommand>();
  CLI::App& command = *app.add_subcommand("watch", "Show the frames that others send to a scene, or list scenes");
  command.footer(
      "Without SCENE, the scenes of the daemon are listed. On a terminal the last frames are a table, which the key\n"
      "q or an interrupt ends; else each frame is a line.");
  command.add_option("scene", options->scene_id, "Id of the scene")->type_name("ID")->check(scene_id());
  command.add_flag("--list", options->list, "List the scenes that can be watched, as without SCENE");
  command.add_option("--interval", options->watch.frame_interval, "Every so many frames (default: every one)")
      ->check(CLI::Range(uint32_t{0}, UINT32_MAX));
  command.add_option("--rate", options->watch.max_frames_per_second, "At most so many frames a second (0: no limit)");
  command.add_option("--frames", options->frames, "End after so many of them (0: with the scene)")
      ->check(whole_number());
  auto* record = command.add_option("--record", options->record, "File that takes the frames, for 'collidectl replay'");
  auto* mesh = command.add_option("--mesh", options->meshes,
                                  "Files with the scene's meshes, in its order, which --record needs for their "
                                  "elements: in one file or several");
  mesh->needs(record);
  record->needs(mesh);
  add_server_options(command, options->server);
  command.add_flag("--table", options->table, "A table that follows the frames, the default on a terminal");
  command.add_flag("--plain", options->plain, "A line for each frame, the default otherwise");
  command.add_flag("--json", options->json, "Print each frame as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
