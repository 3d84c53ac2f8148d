// collidectl watch: the frames that others send to a scene, a line each.

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include "client/cli/commands.hpp"
#include "client/cli/daemon/connection.hpp"
#include "client/cli/daemon/interrupt.hpp"
#include "client/cli/options/options.hpp"
#include "client/cli/options/usage_error.hpp"
#include "client/cli/output/output.hpp"
#include "client/cli/report/json.hpp"

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

Json frame_line(const client::WatchedFrame& frame, v1::Report report) {
  Json line = {{"frame", frame.frame_id},
               {"skipped_frames", frame.skipped_frames},
               {"contact_count", frame.done.contact_count()},
               {"any_contact", frame.done.any_contact()},
               {"earliest_toi", frame.done.earliest_toi()}};
  line.update(frame_json(frame.done, report));
  return line;
}

std::string text_line(const client::WatchedFrame& frame) {
  const v1::FrameCounts& counts = frame.done.metrics().counts();
  char line[256];
  std::snprintf(
      line, sizeof line, "frame %llu: %llu contacts (%llu vt, %llu ee, %llu tt), earliest %.6g, %.3f ms, %llu skipped",
      static_cast<unsigned long long>(frame.frame_id), static_cast<unsigned long long>(frame.done.contact_count()),
      static_cast<unsigned long long>(counts.contacts_vertex_triangle()),
      static_cast<unsigned long long>(counts.contacts_edge_edge()),
      static_cast<unsigned long long>(counts.contacts_triangle_triangle()), frame.done.earliest_toi(),
      frame.done.metrics().total_milliseconds(), static_cast<unsigned long long>(frame.skipped_frames));
  return line;
}

/// Each line is flushed: whoever reads it watches, too.
void print(const WatchCommand& options, const client::WatchedFrame& frame, v1::Report report) {
  const std::string line = options.json ? frame_line(frame, report).dump() : text_line(frame);
  if (std::printf("%s\n", line.c_str()) < 0 || std::fflush(stdout) != 0) throw OutputClosed(errno);
}

void run(const WatchCommand& options) {
  if (options.server.server.empty()) throw UsageError("watch needs --server, the daemon that has the scene");
  defer_interrupts();
  Connection connection(options.server);
  client::Watcher watcher = connection->watch(options.scene_id, options.watch);
  const EndOnInterrupt end(watcher);
  try {
    for (uint64_t shown = 0; options.frames == 0 || shown < options.frames; ++shown)
      print(options, watcher.receive(), watcher.scene().spec().report());
  } catch (const client::Error&) {
    check_interrupt();
    throw;
  }
}

}  // namespace

void add_watch(CLI::App& app) {
  auto options = std::make_shared<WatchCommand>();
  CLI::App& command = *app.add_subcommand("watch", "Show the frames that others send to a scene, a line each");
  command.add_option("scene", options->scene_id, "Id of the scene")->required();
  command.add_option("--interval", options->watch.frame_interval, "Every so many frames (default: every one)");
  command.add_option("--rate", options->watch.max_frames_per_second, "At most so many frames a second (0: no limit)");
  command.add_option("--frames", options->frames, "End after so many lines (0: with the scene)");
  add_server_options(command, options->server);
  command.add_flag("--json", options->json, "Print each frame as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
