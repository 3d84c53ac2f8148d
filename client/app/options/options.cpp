// Options that several subcommands share.

#include "client/app/options/options.hpp"

#include <algorithm>

#include "client/app/options/finite.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/cpp/error.hpp"
#include "client/cpp/transport/grpc/address.hpp"

namespace collided::cli {

namespace {

// Option words for the protocol's values.
template <class T>
using Words = std::vector<std::pair<std::string, T>>;

const Words<v1::Accuracy> kAccuracies{{"candidates", v1::ACCURACY_CANDIDATES},
                                      {"fast", v1::ACCURACY_FAST},
                                      {"guarded", v1::ACCURACY_GUARDED},
                                      {"certified", v1::ACCURACY_CERTIFIED},
                                      {"exact", v1::ACCURACY_EXACT}};
const Words<v1::Report> kReports{
    {"all", v1::REPORT_ALL}, {"earliest", v1::REPORT_EARLIEST_ONLY}, {"any", v1::REPORT_ANY_HIT}};
const Words<v1::PositionFormat> kFormats{
    {"f32", v1::POSITION_FORMAT_F32}, {"f64", v1::POSITION_FORMAT_F64}, {"q16", v1::POSITION_FORMAT_Q16}};
const Words<v1::ContactKind> kKinds{{"vt", v1::CONTACT_KIND_VERTEX_TRIANGLE},
                                    {"ee", v1::CONTACT_KIND_EDGE_EDGE},
                                    {"tt", v1::CONTACT_KIND_TRIANGLE_TRIANGLE},
                                    {"et", v1::CONTACT_KIND_EDGE_TRIANGLE},
                                    {"vs", v1::CONTACT_KIND_VERTEX_SOLID}};

const Words<v1::BroadPhaseEngine> kEngines{{"auto", v1::BROAD_PHASE_ENGINE_UNSPECIFIED},
                                           {"octree", v1::BROAD_PHASE_ENGINE_OCTREE},
                                           {"top-down", v1::BROAD_PHASE_ENGINE_TOP_DOWN_OCTREE},
                                           {"bottom-up", v1::BROAD_PHASE_ENGINE_BOTTOM_UP_OCTREE},
                                           {"uniform-grid", v1::BROAD_PHASE_ENGINE_UNIFORM_GRID},
                                           {"two-level-grid", v1::BROAD_PHASE_ENGINE_TWO_LEVEL_GRID},
                                           {"lbvh", v1::BROAD_PHASE_ENGINE_LBVH},
                                           {"vss", v1::BROAD_PHASE_ENGINE_VSS},
                                           {"all-pairs", v1::BROAD_PHASE_ENGINE_ALL_PAIRS}};

// ALL_OR_ONE is sent as no value, so that older daemons take it.
const Words<v1::AdvanceMode> kAdvanceModes{{"all-or-one", v1::ADVANCE_MODE_UNSPECIFIED},
                                           {"per-mesh", v1::ADVANCE_MODE_PER_MESH},
                                           {"per-vertex", v1::ADVANCE_MODE_PER_VERTEX}};

const Words<v1::Reuse> kReuses{{"auto", v1::REUSE_UNSPECIFIED}, {"on", v1::REUSE_ON}, {"off", v1::REUSE_OFF}};
const Words<v1::ListUse> kListUses{
    {"none", v1::LIST_USE_NONE}, {"made", v1::LIST_USE_MADE}, {"reused", v1::LIST_USE_REUSED}};

template <class T>
std::vector<std::string> names_of(const Words<T>& words) {
  std::vector<std::string> out;
  for (const auto& [word, value] : words) out.push_back(word);
  return out;
}

template <class T>
CLI::IsMember one_of(const Words<T>& words) {
  return CLI::IsMember(names_of(words));
}

template <class T>
T value_of(const Words<T>& words, const std::string& wanted) {
  return std::find_if(words.begin(), words.end(), [&](const auto& pair) { return pair.first == wanted; })->second;
}

template <class T>
std::string word_of(const Words<T>& words, T wanted) {
  const auto at = std::find_if(words.begin(), words.end(), [&](const auto& pair) { return pair.second == wanted; });
  return at == words.end() ? std::to_string(wanted) : at->first;
}

bool wants(const DetectionOptions& options, const char* kind) {
  return std::count(options.kinds.begin(), options.kinds.end(), kind) > 0;
}

/// With solids, vertices inside them are contacts, too.
std::vector<std::string> wanted_kinds(const DetectionOptions& options) {
  std::vector<std::string> kinds = options.kinds;
  if (has_solids(options) && !wants(options, "vs")) kinds.push_back("vs");
  return kinds;
}

/// Refuses an address that no daemon can have, before anything is done.
CLI::Validator address() {
  const auto check = [](const std::string& word) {
    try {
      client::check_address(word);
      return std::string();
    } catch (const client::Error& e) {
      return e.message();
    }
  };
  return CLI::Validator(check, "");
}

void add_security_options(CLI::App& command, ServerOptions& options, CLI::Option* server) {
  command.add_option("--token-file", options.token_file, "File with the bearer token")
      ->type_name("FILE")
      ->needs(server);
  auto* ca = command.add_option("--tls-ca", options.tls_ca, "Certificates to trust (PEM); with it, TLS is used")
                 ->type_name("FILE")
                 ->needs(server);
  auto* certificate = command.add_option("--tls-cert", options.tls_certificate, "The client's own certificate (PEM)")
                          ->type_name("FILE")
                          ->needs(ca);
  auto* key =
      command.add_option("--tls-key", options.tls_key, "Its private key (PEM)")->type_name("FILE")->needs(certificate);
  certificate->needs(key);
  command
      .add_option("--daemon-user", options.daemon_user,
                  "User, by name or id, to share memory with besides root and oneself")
      ->type_name("USER")
      ->needs(server);
}

}  // namespace

void add_server_options(CLI::App& command, ServerOptions& options) {
  auto* server = command.add_option("--server", options.server, "Address of a running daemon; default: start one")
                     ->type_name("ADDRESS")
                     ->check(address());
  command.add_option("--backend", options.backend, "Where the scene lives: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  command
      .add_option(
          "--part-devices", options.part_devices,
          "Spread the scene over these devices, a part on each, such as cuda:0,cuda:1; pays in large scenes alone")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("DEVICES");
  command.add_option("--threads", options.threads, "CPU threads of its own daemon; 0: all cores")
      ->check(CLI::Range(0, 4096))
      ->excludes(server);
  add_security_options(command, options, server);
}

void add_detection_options(CLI::App& command, DetectionOptions& options) {
  command.add_option("--mode", options.mode, "ccd: between two frames; dcd: in one frame")
      ->check(CLI::IsMember({"ccd", "dcd"}))
      ->capture_default_str();
  command.add_option("--accuracy", options.accuracy, "Accuracy level, from fastest to exact")
      ->check(one_of(kAccuracies))
      ->capture_default_str();
  command.add_option("--thickness", options.thickness, "Contact distance, in the unit of the positions")
      ->check(finite())
      ->check(at_least_zero())
      ->capture_default_str();
  command
      .add_option("--delta", options.delta, "Tolerance of ccd, in the unit of the positions; 0: by each pair's size")
      ->check(finite())
      ->check(at_least_zero())
      ->capture_default_str();
  command.add_option("--report", options.report, "all contacts, the earliest one, or only whether there is any")
      ->check(one_of(kReports))
      ->capture_default_str();
  command
      .add_option("--kinds", options.kinds,
                  "Vertex-triangle, edge-edge, triangle-triangle (dcd, or candidates), edge-triangle (edges that go "
                  "through triangles, dcd), vertex-solid (vertices inside other meshes, with --solid), such as vt,tt")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(one_of(kKinds))
      ->default_str("vt,ee");
  command.add_option("--engine", options.engine, "How pairs of triangles are found; auto: the daemon chooses")
      ->check(one_of(kEngines))
      ->capture_default_str();
  command
      .add_option("--reuse", options.reuse,
                  "Lists of pairs that may touch in the next frames; auto: where they are faster, if --engine is auto")
      ->check(one_of(kReuses))
      ->capture_default_str();
}

void add_advance_options(CLI::App& command, DetectionOptions& options) {
  auto* advance = command.add_flag("--advance", options.advance, "Go only as far as is certified");
  command.add_option("--advance-mode", options.advance_mode, "What goes its own fraction of the way with --advance")
      ->needs(advance)
      ->check(one_of(kAdvanceModes))
      ->capture_default_str();
  command.add_flag("--limits", options.limits, "Count the contacts that limit how far --advance goes")->needs(advance);
  command.add_option("--min-separation", options.min_separation, "Distance that --advance keeps between features")
      ->needs(advance)
      ->check(finite())
      ->check(at_least_zero())
      ->capture_default_str();
}

void add_engines_option(CLI::App& command, std::vector<std::string>& engines) {
  command.add_option("--engine", engines, "How pairs of triangles are found, one run each, such as octree,lbvh")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(one_of(kEngines))
      ->default_str("auto");
}

void add_position_format_option(CLI::App& command, std::string& format) {
  command.add_option("--position-format", format, "Positions on the wire; q16: 16 bits in the box of the whole motion")
      ->check(one_of(kFormats))
      ->capture_default_str();
}

void add_automatic_format_option(CLI::App& command, std::string& format) {
  std::vector<std::string> names = position_formats();
  names.insert(names.begin(), kAutomaticFormat);
  command
      .add_option(
          "--position-format", format,
          "Positions on the wire; auto: f64 if one in a file is not exactly a float, else f32; q16: 16 bits in the "
          "box of the whole motion")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
}

void check_usage(const DetectionOptions& options) {
  const v1::Accuracy accuracy = value_of(kAccuracies, options.accuracy);
  const bool dcd = options.mode == "dcd";
  if (options.report == "earliest" && (dcd || accuracy < v1::ACCURACY_GUARDED))
    throw UsageError("--report earliest needs --mode ccd and --accuracy guarded, certified or exact");
  if (options.report == "any" && accuracy < v1::ACCURACY_FAST)
    throw UsageError("--report any needs --accuracy fast, guarded, certified or exact");
  if (wants(options, "tt") && !dcd && accuracy != v1::ACCURACY_CANDIDATES)
    throw UsageError("--kinds tt needs --mode dcd or --accuracy candidates");
  if (wants(options, "et") && (!dcd || accuracy == v1::ACCURACY_CANDIDATES))
    throw UsageError("--kinds et needs --mode dcd and --accuracy fast, guarded, certified or exact");
  if (has_solids(options) && (!dcd || accuracy == v1::ACCURACY_CANDIDATES))
    throw UsageError("--solid needs --mode dcd and --accuracy fast, guarded, certified or exact");
  if (wants(options, "vs") && !has_solids(options)) throw UsageError("--kinds vs needs --solid");
  const bool by_distance = wants(options, "vt") || wants(options, "ee");
  const bool may_advance = !dcd && accuracy >= v1::ACCURACY_CERTIFIED && wants(options, "vt") && wants(options, "ee");
  if (options.advance && !may_advance)
    throw UsageError("--advance needs --mode ccd, --accuracy certified or exact, and the kinds vt and ee");
  if (dcd && by_distance && accuracy == v1::ACCURACY_FAST && options.thickness == 0 && options.half_thicknesses.empty())
    throw UsageError("--mode dcd with --accuracy fast needs a --thickness greater than 0 for the kinds vt and ee");
}

void set_advance(const DetectionOptions& detection, v1::Frame& frame) {
  frame.set_advance(detection.advance);
  frame.set_advance_mode(value_of(kAdvanceModes, detection.advance_mode));
  frame.set_limits(detection.limits);
}

void set_place(const ServerOptions& server, v1::SceneSpec& spec) {
  spec.set_backend(server.backend == "cpu"    ? v1::BACKEND_CPU
                   : server.backend == "cuda" ? v1::BACKEND_CUDA
                                              : v1::BACKEND_AUTO);
  spec.mutable_part_devices()->Assign(server.part_devices.begin(), server.part_devices.end());
}

v1::SceneSpec scene_spec(const ServerOptions& server, const DetectionOptions& detection, v1::PositionFormat format) {
  v1::SceneSpec spec;
  set_place(server, spec);
  spec.set_mode(detection.mode == "dcd" ? v1::DETECTION_MODE_DCD : v1::DETECTION_MODE_CCD);
  spec.set_accuracy(value_of(kAccuracies, detection.accuracy));
  spec.set_thickness(detection.thickness);
  spec.set_delta(detection.delta);
  spec.set_min_separation(detection.min_separation);
  spec.set_report(value_of(kReports, detection.report));
  spec.set_broad_phase_engine(value_of(kEngines, detection.engine));
  spec.set_reuse(value_of(kReuses, detection.reuse));
  for (const std::string& kind : wanted_kinds(detection)) spec.add_kinds(value_of(kKinds, kind));
  spec.set_position_format(format);
  return spec;
}

std::vector<std::pair<std::string, OptionValue>> described(const v1::SceneSpec& spec) {
  std::vector<std::string> kinds;
  for (const int kind : spec.kinds()) kinds.push_back(name_of(static_cast<v1::ContactKind>(kind)));
  return {{"mode", spec.mode() == v1::DETECTION_MODE_DCD ? "dcd" : "ccd"},
          {"accuracy", name_of(spec.accuracy())},
          {"position_format", name_of(spec.position_format())},
          {"thickness", spec.thickness()},
          {"delta", spec.delta()},
          {"min_separation", spec.min_separation()},
          {"report", name_of(spec.report())},
          {"kinds", kinds},
          {"engine", name_of(spec.broad_phase_engine())},
          {"reuse", name_of(spec.reuse())}};
}

std::vector<std::string> position_formats() { return names_of(kFormats); }
v1::PositionFormat format_of(const std::string& name) { return value_of(kFormats, name); }
v1::PositionFormat choose_format(const std::string& name, bool is_double) {
  if (name != kAutomaticFormat) return format_of(name);
  return is_double ? v1::POSITION_FORMAT_F64 : v1::POSITION_FORMAT_F32;
}

std::string name_of(v1::Backend backend) {
  switch (backend) {
    case v1::BACKEND_CPU:
      return "cpu";
    case v1::BACKEND_CUDA:
      return "cuda";
    default:
      return "auto";
  }
}

std::string name_of(v1::PositionFormat format) {
  return word_of(kFormats, format == v1::POSITION_FORMAT_UNSPECIFIED ? v1::POSITION_FORMAT_F32 : format);
}
std::string name_of(v1::Accuracy accuracy) { return word_of(kAccuracies, accuracy); }
std::string name_of(v1::Report report) { return word_of(kReports, report); }
std::string name_of(v1::ContactKind kind) { return word_of(kKinds, kind); }
std::string name_of(v1::BroadPhaseEngine engine) { return word_of(kEngines, engine); }
std::string name_of(v1::Reuse reuse) { return word_of(kReuses, reuse); }
std::string name_of(v1::ListUse use) { return word_of(kListUses, use); }

}  // namespace collided::cli
