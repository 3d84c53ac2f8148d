// collidectl stream: plays a procedural scene through a daemon and reports what its frames cost.

#include <chrono>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>

#include "client/cli/commands.hpp"
#include "client/cli/daemon/connection.hpp"
#include "client/cli/daemon/interrupt.hpp"
#include "client/cli/input/mesh_input.hpp"
#include "client/cli/input/rigid_motion.hpp"
#include "client/cli/options/exclusion_options.hpp"
#include "client/cli/options/options.hpp"
#include "client/cli/options/scene_options.hpp"
#include "client/cli/output/progress.hpp"
#include "client/cli/report/contacts.hpp"
#include "client/cli/report/json.hpp"
#include "client/cli/report/text.hpp"
#include "client/measure/stage_medians.hpp"
#include "client/measure/statistics.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

namespace {

struct StreamOptions {
  ServerOptions server;
  DetectionOptions detection;
  ExclusionOptions exclusions;
  SceneOptions scene;
  std::vector<std::string> rigid;  ///< names of meshes
  std::string position_format = "f32";
  bool json = false;
};

/// Sums over the frames. Contacts are counted and dropped, except the earliest.
struct Totals {
  std::vector<v1::FrameMetrics> metrics;
  uint64_t contacts = 0;
  client::PerKind<uint64_t> of_kind;
  uint64_t bytes_in = 0, bytes_out = 0, replays = 0;
  bool any_contact = false;
  std::optional<double> least_advanced;
  std::optional<Json> earliest;

  void add(client::FrameOutput output) {
    output.check();
    const v1::FrameMetrics& m = output.done.metrics();
    contacts += output.done.contact_count();
    for_each_kind([](v1::ContactKind, uint64_t& sum, const client::Contacts& found) { sum += found.count; }, of_kind,
                  output);
    any_contact |= output.done.any_contact();
    bytes_in += m.bytes_in();
    bytes_out += m.bytes_out();
    replays += m.replays();
    if (output.done.has_advanced()) least_advanced = std::min(least_advanced.value_or(1), output.done.advanced());
    keep_earliest(output);
    metrics.push_back(std::move(*output.done.mutable_metrics()));
  }

 private:
  void keep_earliest(const client::FrameOutput& output) {
    const auto contact = earliest_contact(output);
    if (!contact || (earliest && earliest->at("toi") <= contact->at("toi"))) return;
    earliest = Json{{"frame", output.frame_id}};
    earliest->update(*contact);
  }
};

/// What a stream plays.
struct Play {
  const StreamOptions& options;
  const scenes::Scene& scene;
  const v1::SceneSpec& spec;
  std::vector<uint32_t> rigid;
};

/// Adds to the totals frame by frame, so that they are valid however this ends.
void play(client::FrameStream& stream, const Play& played, Totals& totals) {
  const SceneOptions& options = played.options.scene;
  RigidMotion rigid(played.scene.meshes(), played.rigid);
  Progress progress;
  const auto take = [&] {
    totals.add(receive(stream));
    progress.show("frames", static_cast<int>(totals.metrics.size()), options.frames);
  };
  for (int sent = 0; sent < options.frames; ++sent) {
    check_interrupt();
    if (sent >= static_cast<int>(totals.metrics.size() + stream.window())) take();
    const auto id = static_cast<uint64_t>(sent) + 1;
    std::vector<scenes::Vec3d> positions = played.scene.positions(options.time(sent));
    v1::Frame frame = make_frame(played.scene.meshes(), id, played.spec, positions);
    frame.set_advance(played.options.detection.advance);
    if (!played.rigid.empty()) rigid.apply_to(frame, std::move(positions));
    stream.send(frame);
  }
  while (static_cast<int>(totals.metrics.size()) < options.frames) take();
  stream.finish();
}

Json contacts_json(const StreamOptions& options, const Totals& totals) {
  if (options.detection.report == "any") return {{"contact_count", nullptr}, {"any_contact", totals.any_contact}};
  Json out = {{"contact_count", totals.contacts}};
  out.update(contact_counts_json(totals.of_kind));
  out["any_contact"] = totals.any_contact;
  if (totals.least_advanced) out["least_advanced"] = *totals.least_advanced;
  if (totals.earliest) out["earliest"] = *totals.earliest;
  return out;
}

/// Medians over the frames.
Json times_json(const std::vector<v1::FrameMetrics>& frames) {
  const auto median_of = [&](double (v1::FrameMetrics::*time)() const) {
    std::vector<double> ms;
    for (const v1::FrameMetrics& frame : frames) ms.push_back((frame.*time)());
    return median(std::move(ms));
  };
  Json stages = median_stages(frames);
  stages.erase("total");
  return {{"total_ms", median_of(&v1::FrameMetrics::total_milliseconds)},
          {"queue_ms", median_of(&v1::FrameMetrics::queue_milliseconds)},
          {"step_ms", median_of(&v1::FrameMetrics::step_milliseconds)},
          {"stage_ms", stages}};
}

Json summary_json(const StreamOptions& options, const v1::Scene& scene, const Totals& totals, double seconds) {
  const v1::FrameMetrics& last = totals.metrics.back();
  Json counts = counts_json(last.counts());
  if (options.detection.report == "any") clear_contact_counts(counts);
  Json out = {{"name", options.scene.name},
              {"scale", options.scene.scale},
              {"scene", scene_json(scene)},
              {"frames", totals.metrics.size()},
              {"seconds", seconds}};
  out.update(contacts_json(options, totals));
  out["median"] = times_json(totals.metrics);
  out["last_frame"] = {{"counts", counts}, {"device_bytes", last.device_bytes()}};
  out["replays"] = totals.replays;
  out["bytes_in"] = totals.bytes_in;
  out["bytes_out"] = totals.bytes_out;
  out["warnings"] = warnings_json(totals.metrics);
  return out;
}

/// If something ends it early, reports the frames so far.
void play_and_report(const Play& played, const v1::Scene& scene, client::FrameStream& stream) {
  const StreamOptions& options = played.options;
  const auto start = std::chrono::steady_clock::now();
  Totals totals;
  std::exception_ptr failure;
  try {
    play(stream, played, totals);
  } catch (const std::exception&) {
    failure = std::current_exception();
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  if (!totals.metrics.empty()) {
    Json summary = summary_json(options, scene, totals, took.count());
    summary.update(transport_json(stream));
    std::printf("%s", options.json ? (summary.dump() + "\n").c_str() : report_text(summary).c_str());
  }
  if (failure) std::rethrow_exception(failure);
}

void run(const StreamOptions& options) {
  check_usage(options.detection);
  const auto procedural = scenes::make_scene(options.scene.name, options.scene.scale);
  v1::SceneSpec spec = scene_spec(options.server, options.detection, format_of(options.position_format));
  spec.set_display_name(options.scene.name);
  spec.set_rest_distance(options.exclusions.rest_distance);
  for (int frame = 0; frame < options.scene.frames && options.position_format == "q16"; ++frame)
    grow_box(spec, procedural->positions(options.scene.time(frame)));
  std::vector<client::MeshInput> meshes = mesh_inputs(procedural->meshes());
  options.exclusions.apply_to(meshes);
  options.exclusions.exclude_meshes(spec, meshes);
  Play played{options, *procedural, spec, {}};
  for (const std::string& name : options.rigid) {
    played.rigid.push_back(mesh_of(meshes, "--rigid", name));
    meshes[played.rigid.back()].is_rigid = true;
  }
  Connection connection(options.server);
  const SceneGuard scene = connection.create_scene(spec, meshes);
  client::FrameStream stream = connection.stream(*scene);
  play_and_report(played, *scene, stream);
}

}  // namespace

void add_stream(CLI::App& app) {
  auto options = std::make_shared<StreamOptions>();
  CLI::App& command = *app.add_subcommand("stream", "Play a procedural scene and tell what its frames cost");
  add_scene_options(command, options->scene);
  add_detection_options(command, options->detection);
  add_advance_options(command, options->detection);
  command.add_option("--rigid", options->rigid, "Meshes that move as rigid bodies, and send poses, such as ball")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_mesh_pairs_option(command, options->exclusions);
  add_ring_option(command, options->exclusions);
  add_rest_options(command, options->exclusions);
  add_server_options(command, options->server);
  add_position_format_option(command, options->position_format);
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
