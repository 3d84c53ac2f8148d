// collidectl watch: the frames that others send to a scene, a line each.

#include <chrono>
#include <memory>
#include <thread>

#include "client/cli/commands.hpp"
#include "client/cli/daemon/connection.hpp"
#include "client/cli/daemon/interrupt.hpp"
#include "client/cli/options/options.hpp"
#include "client/cli/options/usage_error.hpp"
#include "client/cli/output/output.hpp"
#include "client/cli/report/frame_line.hpp"

namespace collided::cli {

namespace {

struct WatchCommand {
  ServerOptions server;
  std::string scene_id;
  client::WatchOptions watch;
  uint64_t frames = 0;
  bool json = false;
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

std::string line_of(const WatchCommand& options, const client::WatchedFrame& frame, v1::Report report) {
  if (!options.json)
    return "frame " + std::to_string(frame.frame_id) + ": " + frame_text(frame.done, report) + ", " +
           std::to_string(frame.skipped_frames) + " skipped";
  Json line = {{"frame", frame.frame_id}, {"skipped_frames", frame.skipped_frames}};
  line.update(frame_result_json(frame.done, report));
  return line.dump();
}

void run(const WatchCommand& options) {
  if (options.server.server.empty()) throw UsageError("watch needs --server, the daemon that has the scene");
  defer_interrupts();
  Connection connection(options.server);
  client::Watcher watcher = connection->watch(options.scene_id, options.watch);
  const EndOnInterrupt end(watcher);
  try {
    for (uint64_t shown = 0; options.frames == 0 || shown < options.frames; ++shown)
      print_line(line_of(options, watcher.receive(), watcher.scene().spec().report()));
  } catch (const client::Error&) {
    check_interrupt();
    throw;
  }
}

}  // namespace

void add_watch(CLI::App& app) {
  auto options = std::make_shared<WatchCommand>();
  CLI::App& command = *app.add_subcommand("watch", "Show the frames that others send to a scene, a line each");
  command.add_option("scene", options->scene_id, "Id of the scene")->type_name("ID")->required();
  command.add_option("--interval", options->watch.frame_interval, "Every so many frames (default: every one)");
  command.add_option("--rate", options->watch.max_frames_per_second, "At most so many frames a second (0: no limit)");
  command.add_option("--frames", options->frames, "End after so many lines (0: with the scene)");
  add_server_options(command, options->server);
  command.add_flag("--json", options->json, "Print each frame as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
