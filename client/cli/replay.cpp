// collidectl replay: plays a recording of 'stream --record' or 'watch --record' again.

#include <filesystem>
#include <memory>

#include "client/app/daemon/connection.hpp"
#include "client/app/options/options.hpp"
#include "client/cli/commands.hpp"
#include "client/cli/recording/meshes.hpp"
#include "client/cli/recording/reader.hpp"
#include "client/measure/play/run.hpp"

namespace collided::cli {

namespace {

struct ReplayOptions {
  ServerOptions server;
  std::string file;
  bool json = false;
};

void run(const ReplayOptions& options) {
  RecordingReader recording(options.file);
  const RecordedMeshes meshes(recording.spec());
  v1::SceneSpec spec = recording.spec();
  spec.clear_meshes();
  spec.clear_device();  // of the daemon that it was recorded with
  set_place(options.server, spec);
  Connection connection(options.server);
  const SceneGuard scene = connection.create_scene(spec, meshes.inputs());
  client::FrameStream stream = connection.stream(*scene);
  const FrameSource source{.frames = recording.count_frames(), .next = [&] { return recording.next_frame(); }};
  play_and_report(stream, *scene, source,
                  {.input = {{"name", std::filesystem::path(options.file).filename().string()}},
                   .has_lines = true,
                   .json = options.json});
}

}  // namespace

void add_replay(CLI::App& app) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App& command = *app.add_subcommand("replay", "Play a recording of 'stream --record' or 'watch --record' again");
  command.add_option("FILE", options->file, "The recording")->type_name("FILE")->required();
  add_server_options(command, options->server);
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
