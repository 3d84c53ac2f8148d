// collidectl render: pictures of steps, with their contacts marked.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "client/app/daemon/connection.hpp"
#include "client/app/input/frame_files.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/input/motion.hpp"
#include "client/app/input/step_input.hpp"
#include "client/app/options/mesh_options.hpp"
#include "client/app/options/options.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/numbered.hpp"
#include "client/app/output/output.hpp"
#include "client/app/report/frame_line.hpp"
#include "client/cli/commands.hpp"
#include "client/cli/picture/draw.hpp"

namespace collided::cli {

namespace {

struct RenderOptions {
  ServerOptions server;
  DetectionOptions detection;
  SceneOptions scene{.name = "", .frames = 0};  // 0: as many as one picture takes
  std::vector<std::string> meshes;              ///< files of meshes that stand still
  std::vector<std::string> frames;              ///< files of one mesh, or with --scene their number
  std::vector<std::string> files;               ///< of frames
  std::string position_format = kAutomaticFormat;
  PictureOptions picture;
  std::string size, up = "z";
  std::string out;
  bool has_crossings = false;
  bool json = false;
};

bool is_ccd(const RenderOptions& options) { return options.detection.mode == "ccd"; }

void check_usage(const RenderOptions& options) {
  const int inputs = !options.scene.name.empty() + !options.files.empty() + !options.meshes.empty();
  if (inputs != 1) throw UsageError("render needs one of MESH..., --frames and --scene");
  if (!options.meshes.empty() && is_ccd(options))
    throw UsageError("--mode ccd needs two frames, --frames FRAME0 FRAME1; what was given stands still");
  check_usage(options.detection);
  if (options.detection.accuracy == "candidates")
    throw UsageError("render marks contacts; --accuracy candidates has none");
  if (options.detection.report == "any")
    throw UsageError("render marks contacts; --report any tells only whether there is one");
  if (!is_ccd(options) && options.picture.time != 1)
    throw UsageError("--time needs --mode ccd: one frame has no motion");
  check_one_output(options.out, options.json);
}

Motion motion_of(const RenderOptions& options) {
  if (!options.files.empty()) return file_motion(options.files);
  if (!options.meshes.empty()) {
    const auto step = std::make_shared<const StepInput>(file_meshes(options.meshes));
    return {.name = step->name,
            .meshes = step->meshes,
            .frames = 1,
            .files = {},
            .is_double = step->is_double,
            .notes = step->notes,
            .positions = [step](int) { return step->end; }};
  }
  SceneOptions scene = options.scene;
  if (scene.frames == 0) scene.frames = is_ccd(options) ? 2 : 1;
  return scene_motion(scene);
}

/// How many pictures there are of the motion.
int count_pictures(const RenderOptions& options, const Motion& motion) {
  const int pictures = motion.frames - (is_ccd(options) ? 1 : 0);
  if (pictures < 1) throw UsageError("--mode ccd needs two frames or more; 1 was given");
  return pictures;
}

/// The file of each picture, as a pattern.
std::string pattern_of(const RenderOptions& options, int pictures) {
  if (options.out.empty()) return pictures > 1 ? "contacts_{frame}.png" : "contacts.png";
  if (pictures > 1 && !is_numbered(options.out))
    throw UsageError("--out " + options.out + ": " + std::to_string(pictures) +
                     " pictures need {frame} in the name, such as contacts_{frame}.png");
  return options.out;
}

/// Finds which edges go through which triangles, exactly, in positions that need not be those of any frame.
class CrossingFinder {
 public:
  CrossingFinder(Connection& connection, const RenderOptions& options, const Motion& motion)
      : motion_(motion),
        spec_(spec_of(connection, options.server)),
        scene_(connection.create_scene(spec_, mesh_inputs(motion.meshes))),
        stream_(connection.stream(*scene_)) {}
  client::Contacts find(client::Positions positions) {
    client::FrameOutput output = run_frame(stream_, make_frame(motion_.meshes, ++frame_, spec_, positions));
    return std::move(output.edge_triangle);
  }

 private:
  static v1::SceneSpec spec_of(const Connection& connection, const ServerOptions& server) {
    DetectionOptions exact;
    exact.mode = "dcd", exact.accuracy = "exact", exact.kinds = {"et"};
    v1::SceneSpec spec = scene_spec(server, exact, v1::POSITION_FORMAT_F64);
    connection.ask_for_all_fields(spec);
    return spec;
  }

  const Motion& motion_;
  const v1::SceneSpec spec_;
  const SceneGuard scene_;
  client::FrameStream stream_;
  uint64_t frame_ = 0;
};

class Renderer {
 public:
  Renderer(const RenderOptions& options, const Motion& motion, const std::string& pattern, int pictures)
      : options_(options),
        motion_(motion),
        pattern_(pattern),
        pictures_(pictures),
        connection_(options.server),
        spec_(spec_of()),
        scene_(connection_.create_scene(spec_, described_inputs(motion.meshes, options.detection))),
        stream_(connection_.stream(*scene_)),
        drawing_(options.picture, motion) {
    if (options.has_crossings) crossings_.emplace(connection_, options, motion);
  }

  /// If something ends it early, tells the pictures so far.
  void run() {
    Json frames = Json::array();
    try {
      for (int picture = 1; picture <= pictures_; ++picture) frames.push_back(draw(picture));
    } catch (const std::exception&) {
      if (!frames.empty()) tell(frames);
      throw;
    }
    tell(frames);
  }

 private:
  void tell(const Json& frames) const {
    if (!options_.json) return;  // each has its line
    const Json summary = {{"name", motion_.name}, {"scene", scene_json(*scene_)}, {"per_frame", frames}};
    std::printf("%s\n", json_text(summary).c_str());
  }

  v1::SceneSpec spec_of() const {
    v1::SceneSpec spec =
        scene_spec(options_.server, options_.detection, choose_format(options_.position_format, motion_.is_double));
    connection_.ask_for_all_fields(spec);
    grow_box(spec, motion_);
    return spec;
  }

  /// One picture; what it shows, as JSON.
  Json draw(int picture) {
    const int last = picture - (is_ccd(options_) ? 0 : 1);
    const std::vector<scenes::Vec3d> end = motion_.positions(last);
    const std::vector<scenes::Vec3d> start =
        is_ccd(options_) ? motion_.positions(last - 1) : std::vector<scenes::Vec3d>{};
    const auto id = static_cast<uint64_t>(picture);
    const client::FrameOutput output = run_frame(stream_, make_frame(motion_.meshes, id, spec_, end, start));
    Drawn drawn = drawing_.step({start, end}, output);
    std::optional<uint64_t> crossing_count;
    if (crossings_) {
      const client::Contacts found = crossings_->find(drawn.positions);
      crossing_count = found.count;
      drawing_.add_crossings(drawn, found);
    }
    const Image image = drawing_.paint(drawn);
    check_interrupt();
    const std::string out = numbered(pattern_, id);
    write_png(out, image);
    return report(last, out, output, crossing_count);
  }

  Json report(int last, const std::string& out, const client::FrameOutput& output,
              std::optional<uint64_t> crossings) const {
    const v1::SceneSpec& spec = scene_->spec();
    if (!options_.json)
      print_summary(
          out, (is_standard_output(out) ? "" : out + ": ") + frame_text(output.done, spec) +
                   (crossings ? ", " + std::to_string(*crossings) + " crossings of edges and triangles" : "") + "\n");
    Json json = {{"frame", output.frame_id}};
    if (!motion_.files.empty()) json["file"] = motion_.files[static_cast<size_t>(last)];
    json["out"] = out;
    if (crossings) json["crossing_count"] = *crossings;
    json.update(frame_result_json(output.done, spec));
    return json;
  }

  const RenderOptions& options_;
  const Motion& motion_;
  const std::string pattern_;
  const int pictures_;
  Connection connection_;
  const v1::SceneSpec spec_;
  const SceneGuard scene_;
  client::FrameStream stream_;
  std::optional<CrossingFinder> crossings_;
  Drawing drawing_;
};

/// --frames is a number with --scene, and else names files; a folder has frames, too. A single frame is a mesh that
/// stands still, as for 'detect'.
void find_frames(RenderOptions& options) {
  if (options.meshes.size() == 1 && std::filesystem::is_directory(options.meshes[0]))
    options.files = std::exchange(options.meshes, {});
  if (options.scene.name.empty()) {
    options.files.insert(options.files.end(), options.frames.begin(), options.frames.end());
    options.files = expand_folders(options.files);
    if (options.meshes.empty() && options.files.size() == 1) options.meshes = std::exchange(options.files, {});
  } else if (!options.frames.empty()) {
    if (options.frames.size() > 1 || !CLI::detail::lexical_cast(options.frames[0], options.scene.frames) ||
        options.scene.frames < 1 || options.scene.frames > 1000000)
      throw UsageError("--frames with --scene needs one number from 1 to 1000000");
  }
}

/// Fills in what the user did not choose, as 'detect' does.
void choose_detection(const CLI::App& command, RenderOptions& options) {
  if (options.meshes.empty()) return;
  if (command.get_option("--mode")->count() == 0) options.detection.mode = "dcd";
  options.has_crossings = options.has_crossings || options.meshes.size() > 1;
}

void run(RenderOptions options) {
  options.picture.view.is_y_up = options.up == "y";
  check_usage(options);
  const Motion motion = motion_of(options);
  const int pictures = count_pictures(options, motion);
  const std::string pattern = pattern_of(options, pictures);
  check_writable("--out", numbered(pattern, 1));
  std::vector<NamedOutput> outputs;
  for (int picture = 1; picture <= pictures; ++picture) outputs.push_back({"--out", numbered(pattern, picture)});
  check_kept(options.meshes.empty() ? options.files : options.meshes, outputs);
  Renderer(options, motion, pattern, pictures).run();
}

void add_picture_options(CLI::App& command, RenderOptions& options) {
  ViewOptions& view = options.picture.view;
  command.add_option(
      "--out", options.out,
      "PNG file, - for standard output; {frame} stands for the picture's number (default: contacts.png)");
  command.add_option("--width", view.width, "Pixels")->check(CLI::Range(16, 8192))->capture_default_str();
  command.add_option("--height", view.height, "Pixels")->check(CLI::Range(16, 8192))->capture_default_str();
  command.add_option("--azimuth", view.azimuth, "Where the viewer is, in degrees around the upward axis")
      ->check(finite())
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  command.add_option("--elevation", view.elevation, "Where the viewer is, in degrees above the horizon")
      ->check(finite())
      ->check(CLI::Range(-90.0, 90.0))
      ->capture_default_str();
  command.add_option("--up", options.up, "The axis that points up: y or z")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  command.add_flag("--zoom-contacts", options.picture.zoom_contacts,
                   "Show what is around the marks, not the whole scene");
  command.add_option("--time", options.picture.time, "Of the step, at which it is drawn: 0 is its start, 1 its end")
      ->check(finite())
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_flag("--crossings", options.has_crossings,
                   "Also draw the contours along which triangles cross, neighbours too, decided exactly");
}

}  // namespace

void add_render(CLI::App& app) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App& command = *app.add_subcommand("render", "Draw meshes with their contacts marked, as PNG");
  command.footer(
      "Contacts of vertices with triangles are vermilion balls and tint the triangle, contacts of edges are blue\n"
      "crosses, contours along which triangles cross purple lines; marks behind a surface shine through it. Each\n"
      "contact is where it happens, at its own time. No display is needed.\n"
      "\n"
      "  collidectl render ball.ply box.obj --thickness 0.01\n"
      "  collidectl render --frames frame_0092.ply frame_0093.ply --zoom-contacts\n"
      "  mkdir -p pictures && collidectl render frames --up y --crossings --out 'pictures/{frame}.png'\n"
      "  collidectl render --scene cloth_ball --t0 0.5 --thickness 0.01 --azimuth 60\n"
      "  collidectl render frame.obj --mode dcd --kinds tt --accuracy exact");
  command.add_option("MESH", options->meshes, "Meshes of one scene: OBJ, PLY, STL, OFF, glTF, GLB or DAE")
      ->type_name("FILE");
  add_optional_scene_options(command, options->scene);
  command.remove_option(command.get_option("--frames"));
  command
      .add_option("--frames", options->frames,
                  "FRAME0 FRAME1 of one mesh for ccd, one for dcd, more for more pictures; with --scene their number")
      ->type_name("FILE")
      ->expected(1, CLI::detail::expected_max_vector_size);
  add_picture_options(command, *options);
  add_detection_options(command, options->detection);
  add_mesh_options(command, options->detection);
  add_server_options(command, options->server);
  add_automatic_format_option(command, options->position_format);
  command.add_flag("--json", options->json, "Print one JSON object");
  command.get_option("--mode")->default_str("dcd for what stands still, else ccd");
  command.callback([options, &command] {
    find_frames(*options);
    choose_detection(command, *options);
    run(*options);
  });
}

}  // namespace collided::cli
