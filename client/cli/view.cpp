// collidectl view: a page that shows a live scene in 3D.

#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "client/app/daemon/connection.hpp"
#include "client/app/daemon/interrupt.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/options/finite.hpp"
#include "client/app/options/mesh_options.hpp"
#include "client/app/options/options.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/output.hpp"
#include "client/app/report/text.hpp"
#include "client/cli/commands.hpp"
#include "client/cli/web/demo.hpp"
#include "client/cli/web/feed.hpp"
#include "client/cli/web/page_file.hpp"
#include "client/cli/web/page_server.hpp"

namespace collided::cli {

namespace {

struct ViewCommand {
  ServerOptions server;
  DetectionOptions detection;
  SceneOptions demo;
  std::vector<std::string> files;  ///< a demo, too
  FeedOptions feed;
  std::string listen = "127.0.0.1:0";
  std::string secret_file;
  std::string page;
};

bool is_demo(const ViewCommand& options) { return !options.demo.name.empty() || !options.files.empty(); }

void check_usage(const ViewCommand& options) {
  const bool is_attached = !is_demo(options);
  if (is_attached && options.server.server.empty())
    throw UsageError("view needs --server, the daemon that has the scene, or --scene or --play for a demo");
  if (!is_attached && !options.feed.scene_id.empty())
    throw UsageError("view shows a SCENE of a daemon, or a demo (--scene, --play), not both");
  if (!options.demo.name.empty() && !options.files.empty())
    throw UsageError("--scene and --play each name a demo; view shows one");
  check_usage(options.detection);
}

/// Runs a thread whose failure ends the command.
class Background {
 public:
  explicit Background(std::function<void(const std::stop_token&)> work)
      : thread_([this, work = std::move(work)](const std::stop_token& stop) {
          try {
            work(stop);
          } catch (...) {
            failure_ = std::current_exception();
            has_failed_ = true;
          }
        }) {}
  /// Throws what ended the thread.
  void check() const {
    if (has_failed_) std::rethrow_exception(failure_);
  }

 private:
  std::exception_ptr failure_;
  std::atomic<bool> has_failed_ = false;
  std::jthread thread_;
};

/// A scene of its own, and its motion.
struct Demo {
  Demo(const ViewCommand& options, Connection& connection)
      : motion(options.files.empty() ? scene_motion(options.demo) : file_motion(options.files)),
        spec(scene_spec(options.server, options.detection, choose_format(kAutomaticFormat, motion.is_double))),
        scene(make_scene(options.detection, connection)),
        stream(connection.stream(*scene)) {}

  SceneGuard make_scene(const DetectionOptions& detection, Connection& connection) {
    spec.set_display_name(shown_name(motion.name));
    return connection.create_scene(spec, described_inputs(motion.meshes, detection));
  }

  Motion motion;
  v1::SceneSpec spec;
  SceneGuard scene;
  client::FrameStream stream;
};

void announce(const PageServer& page) {
  if (page.is_public())
    std::fprintf(stderr,
                 "collidectl: warning: --listen lets other hosts reach the page, in plain text: whoever has or "
                 "overhears its address sees the scene; for remote use prefer a tunnel (ssh -L)\n");
  print_line(page.url());
}

void serve(const ViewCommand& options, PageServer& page, Connection& connection, const FeedOptions& shown, Demo* demo) {
  constexpr std::chrono::milliseconds kPollInterval(50);
  Feed feed(*connection, page, shown);
  std::optional<Background> player;
  if (demo)
    player.emplace([&](const std::stop_token& stop) {
      play_to_and_fro(demo->stream, demo->motion, demo->spec, options.feed.max_frames_per_second, stop);
    });
  const Background watching([&](const std::stop_token& stop) { feed.run(stop); });
  announce(page);
  for (;; std::this_thread::sleep_for(kPollInterval)) {
    check_interrupt();
    watching.check();
    if (player) player->check();
  }
}

void run(const ViewCommand& options) {
  check_usage(options);
  const ListenAddress listen = parse_listen_address(options.listen);
  std::string text = read_page(options.page);
  std::string secret = options.secret_file.empty() ? make_secret() : read_secret(options.secret_file);
  Connection connection(options.server);
  FeedOptions shown = options.feed;
  std::optional<Demo> demo;
  if (is_demo(options))
    shown.scene_id = demo.emplace(options, connection).scene->scene_id();
  else if (!shown.scene_id.empty())
    connection->get_scene(shown.scene_id);  // refused before the page is served
  else
    only_scene(*connection);
  defer_interrupts();
  PageServer page(listen, std::move(text), std::move(secret));
  serve(options, page, connection, shown, demo ? &*demo : nullptr);
}

constexpr auto kFooter =
    "Prints the address of a page and serves it until it is interrupted. The page shows the surfaces, the contacts,\n"
    "the times of the stages and the numbers of contacts; paused, the last frames can be gone through. It watches,\n"
    "and never slows the simulator; large scenes are thinned. Without SCENE it shows the daemon's scene, and the\n"
    "next one once that has ended. The address has a secret: whoever has it sees the scene.\n"
    "\n"
    "  collidectl view --scene cloth_ball                           a demo, with a daemon of its own\n"
    "  collidectl view --play frames/*.ply --mode dcd --thickness 0.01\n"
    "  collidectl view --server unix:/run/collided/socket           the only scene there, or the next one\n"
    "  collidectl view SCENE --server gpu-host:50551 --tls-ca ca.pem --token-file token\n"
    "  ssh -L 8080:127.0.0.1:8080 gpu collidectl view --server localhost:50551 --listen 127.0.0.1:8080";

void add_demo_options(CLI::App& command, ViewCommand& options) {
  add_scene_options(command, options.demo);
  CLI::Option* scene = command.get_option("--scene")->required(false);
  scene->description("Demo: plays a procedural scene to and fro, see 'collidectl scenes'");
  for (const char* of_scenes : {"--frames", "--t0", "--dt", "--scale"}) command.get_option(of_scenes)->needs(scene);
  command.add_option("--play", options.files, "Demo: plays mesh files, a frame each, to and fro");
  add_detection_options(command, options.detection);
  add_mesh_options(command, options.detection);
}

}  // namespace

void add_view(CLI::App& app) {
  auto options = std::make_shared<ViewCommand>();
  CLI::App& command = *app.add_subcommand("view", "Show a live scene in 3D on a page for the browser");
  command.footer(kFooter);
  command.add_option("SCENE", options->feed.scene_id, "Id of the scene; default: the one that there is")
      ->check(scene_id());
  command.add_option("--listen", options->listen, "HOST:PORT of the page; port 0: any")->capture_default_str();
  command.add_option("--secret-file", options->secret_file,
                     "File with the secret of the page's address; default: a new one each time. With it and a fixed "
                     "port, open pages come back once collidectl is started anew");
  command.add_option("--rate", options->feed.max_frames_per_second, "At most so many frames a second")
      ->check(finite())
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command
      .add_option("--contacts", options->feed.max_contacts_per_kind, "At most so many contacts of each kind are drawn")
      ->check(CLI::Range(1, 8192))
      ->capture_default_str();
  command.add_option("--page", options->page, "The page, if not the one that was built or installed with collidectl");
  add_demo_options(command, *options);
  add_server_options(command, options->server);
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
