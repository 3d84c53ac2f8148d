// What is detected, how exactly, how much of it is reported and by which engine.
#include "server/convert/options.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "server/refusals/field_path.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

constexpr std::pair<pb::Accuracy, Accuracy> kAccuracies[] = {{pb::ACCURACY_CANDIDATES, Accuracy::kCandidates},
                                                             {pb::ACCURACY_FAST, Accuracy::kFast},
                                                             {pb::ACCURACY_GUARDED, Accuracy::kGuarded},
                                                             {pb::ACCURACY_CERTIFIED, Accuracy::kCertified},
                                                             {pb::ACCURACY_EXACT, Accuracy::kExact}};

constexpr std::pair<pb::Report, Report> kReports[] = {{pb::REPORT_ALL, Report::kAll},
                                                      {pb::REPORT_EARLIEST_ONLY, Report::kEarliestOnly},
                                                      {pb::REPORT_ANY_HIT, Report::kAnyHit}};

constexpr std::pair<pb::AdvanceMode, AdvanceMode> kAdvanceModes[] = {
    {pb::ADVANCE_MODE_ALL_OR_ONE, AdvanceMode::kAllOrOne},
    {pb::ADVANCE_MODE_PER_MESH, AdvanceMode::kPerMesh},
    {pb::ADVANCE_MODE_PER_VERTEX, AdvanceMode::kPerVertex}};

constexpr std::pair<pb::DetectionMode, Mode> kModes[] = {{pb::DETECTION_MODE_DCD, Mode::kDcd},
                                                         {pb::DETECTION_MODE_CCD, Mode::kCcd},
                                                         {pb::DETECTION_MODE_DCD_AND_CCD, Mode::kBoth}};

constexpr std::pair<pb::BroadPhaseEngine, Engine> kEngines[] = {
    {pb::BROAD_PHASE_ENGINE_OCTREE, Engine::kOctree},
    {pb::BROAD_PHASE_ENGINE_TOP_DOWN_OCTREE, Engine::kTopDown},
    {pb::BROAD_PHASE_ENGINE_BOTTOM_UP_OCTREE, Engine::kBottomUp},
    {pb::BROAD_PHASE_ENGINE_UNIFORM_GRID, Engine::kUniformGrid},
    {pb::BROAD_PHASE_ENGINE_TWO_LEVEL_GRID, Engine::kTwoLevelGrid},
    {pb::BROAD_PHASE_ENGINE_LBVH, Engine::kLbvh},
    {pb::BROAD_PHASE_ENGINE_VSS, Engine::kVss},
    {pb::BROAD_PHASE_ENGINE_ALL_PAIRS, Engine::kAllPairs}};

constexpr std::pair<pb::BroadPhaseReason, EngineReason> kReasons[] = {
    {pb::BROAD_PHASE_REASON_REQUESTED, EngineReason::kAsked},
    {pb::BROAD_PHASE_REASON_FIRST_FRAMES, EngineReason::kFirst},
    {pb::BROAD_PHASE_REASON_COUNTERS, EngineReason::kCounters},
    {pb::BROAD_PHASE_REASON_FASTER, EngineReason::kFaster},
    {pb::BROAD_PHASE_REASON_TRIAL, EngineReason::kTrial}};

constexpr std::pair<pb::Reuse, Reuse> kReuses[] = {{pb::REUSE_ON, Reuse::kOn}, {pb::REUSE_OFF, Reuse::kOff}};

constexpr std::pair<pb::ListUse, ListUse> kListUses[] = {
    {pb::LIST_USE_NONE, ListUse::kNone}, {pb::LIST_USE_MADE, ListUse::kMade}, {pb::LIST_USE_REUSED, ListUse::kReused}};

constexpr std::pair<pb::ReuseReason, ReuseReason> kReuseReasons[] = {
    {pb::REUSE_REASON_REQUESTED, ReuseReason::kAsked},    {pb::REUSE_REASON_UNSUITED, ReuseReason::kUnsuited},
    {pb::REUSE_REASON_FIRST_FRAMES, ReuseReason::kFirst}, {pb::REUSE_REASON_TRIAL, ReuseReason::kTrial},
    {pb::REUSE_REASON_FASTER, ReuseReason::kFaster},      {pb::REUSE_REASON_SLOWER, ReuseReason::kSlower},
    {pb::REUSE_REASON_NO_ROOM, ReuseReason::kNoRoom}};

constexpr std::pair<pb::MeshMotion, MeshMotion> kMotions[] = {{pb::MESH_MOTION_DEFORMABLE, MeshMotion::kDeformable},
                                                              {pb::MESH_MOTION_STATIC, MeshMotion::kStatic},
                                                              {pb::MESH_MOTION_RIGID, MeshMotion::kRigid}};

constexpr std::pair<pb::PositionFormat, Scalar> kFormats[] = {{pb::POSITION_FORMAT_F32, Scalar::kF32},
                                                              {pb::POSITION_FORMAT_F64, Scalar::kF64}};

// Some are no columns of the engine's: stencils are made from the elements, and states are of pairs of meshes.
constexpr std::pair<pb::ContactField, std::variant<ContactField, bool OutputFields::*>> kFields[] = {
    {pb::CONTACT_FIELD_ELEMENTS, ContactField::kElements},
    {pb::CONTACT_FIELD_STENCIL, &OutputFields::stencils},
    {pb::CONTACT_FIELD_TOI, ContactField::kToi},
    {pb::CONTACT_FIELD_DISTANCE, ContactField::kDistance},
    {pb::CONTACT_FIELD_WEIGHTS, ContactField::kWeights},
    {pb::CONTACT_FIELD_NORMAL, ContactField::kNormals},
    {pb::CONTACT_FIELD_FLAGS, ContactField::kFlags},
    {pb::CONTACT_FIELD_FEATURES, ContactField::kFeatures},
    {pb::CONTACT_FIELD_PAIR_STATES, &OutputFields::pair_states},
    {pb::CONTACT_FIELD_SIGNED_DISTANCE, ContactField::kSignedDistance}};

// The rows of each enum that is parsed.
constexpr const auto& rows_of(Accuracy) { return kAccuracies; }
constexpr const auto& rows_of(AdvanceMode) { return kAdvanceModes; }
constexpr const auto& rows_of(Engine) { return kEngines; }
constexpr const auto& rows_of(MeshMotion) { return kMotions; }
constexpr const auto& rows_of(Report) { return kReports; }
constexpr const auto& rows_of(Reuse) { return kReuses; }

template <class Message, class Value, size_t N>
Value find_in(const std::pair<Message, Value> (&values)[N], Message wanted, const std::string& field) {
  for (const auto& [message, value] : values)
    if (message == wanted) return value;
  std::vector<Message> usable;
  for (const auto& [message, value] : values) usable.push_back(message);
  throw_unknown(field, wanted, usable);
}

template <class Message, class Value, size_t N>
std::optional<Value> to_engine(const std::pair<Message, Value> (&values)[N], Message wanted, const std::string& field) {
  if (wanted == Message{}) return {};
  return find_in(values, wanted, field);
}

template <class Message, class Value, size_t N>
Message from_engine(const std::pair<Message, Value> (&values)[N], Value wanted) {
  for (const auto& [message, value] : values)
    if (value == wanted) return message;
  return {};
}

PositionBox parse_box(const pb::QuantizationBox& box, const std::string& field) {
  const auto corner = [&](const auto& from, const char* name, std::array<double, 3>& to) {
    if (from.size() != 3)
      throw_invalid(field + name, fmt::format("has {} numbers, but must have x, y and z", from.size()));
    std::copy(from.begin(), from.end(), to.begin());
  };
  PositionBox out;
  corner(box.lower(), ".lower", out.lower);
  corner(box.upper(), ".upper", out.upper);
  return out;
}

/// The names of an enum's values without their prefix, in lower case, by number.
std::map<int, std::string> labels_of(const google::protobuf::EnumDescriptor& values, std::string_view prefix) {
  std::map<int, std::string> labels;
  for (int i = 0; i < values.value_count(); ++i) {
    std::string label = values.value(i)->name().substr(prefix.size());
    for (char& letter : label) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    labels.emplace(values.value(i)->number(), std::move(label));
  }
  return labels;
}

std::string name_of(Accuracy accuracy) { return pb::Accuracy_Name(to_message(accuracy)); }
std::string name_of(Mode mode) { return pb::DetectionMode_Name(to_message(mode)); }

// Where clients set an option of the scene that the engine names, and how messages call it.
struct OptionPath {
  std::string field, shown;
};

// An entry of one of the spec's lists.
struct ListEntry {
  std::string list;
  const google::protobuf::RepeatedField<int>& (pb::SceneSpec::*entries)() const;
  int number = 0;
  std::string name;
};

ListEntry entry_of(pb::ContactKind kind) {
  return {"spec.kinds", &pb::SceneSpec::kinds, kind, pb::ContactKind_Name(kind)};
}

// The entry that an option of the engine comes from, if it is one that some scenes cannot have.
std::optional<ListEntry> entry_of(const std::string& option) {
  if (option == "triangle_triangle") return entry_of(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  if (option == "edge_triangle") return entry_of(pb::CONTACT_KIND_EDGE_TRIANGLE);
  if (option == "vertex_solid") return entry_of(pb::CONTACT_KIND_VERTEX_SOLID);
  if (option == "pair_states")
    return ListEntry{"spec.fields", &pb::SceneSpec::fields, pb::CONTACT_FIELD_PAIR_STATES,
                     pb::ContactField_Name(pb::CONTACT_FIELD_PAIR_STATES)};
  return std::nullopt;
}

OptionPath path_in(const pb::SceneSpec& spec, const std::string& option) {
  const auto entry = entry_of(option);
  if (!entry) return {spec_path(option), spec_path(option)};
  const auto& entries = (spec.*entry->entries)();
  const std::string field = fmt::format(
      "{}[{}]", entry->list, std::distance(entries.begin(), std::find(entries.begin(), entries.end(), entry->number)));
  return {field, fmt::format("{}, {},", field, entry->name)};
}

constexpr bool always(const FrameInput&) { return true; }
constexpr bool never(const FrameInput&) { return false; }

// An option that a frame has or overrides, or that its mode or its accuracy decides about, as the engine names it.
struct OptionRow {
  std::string_view name;
  bool (*is_frames)(const FrameInput&);  // whether the frame's own value is refused; else its accuracy does not fit
  bool is_of_both;                       // refused for the mode or the accuracy, whose values the engine does not tell
};
constexpr OptionRow kOptions[] = {
    {"mode", always, false},
    {"delta", [](const FrameInput& frame) { return frame.delta.has_value(); }, false},
    {"report", [](const FrameInput& frame) { return frame.report.has_value(); }, true},
    {"triangle_triangle", never, true},
    {"edge_triangle", never, true},
    {"vertex_solid", never, true},
    {"pair_states", never, true},
    {"ignore_separating", always, true},
    {"advance", always, true},
    {"limits", always, false},
    {"start_fraction", always, false},
};

// Options without a row are the scene's alone.
OptionRow row_of(const std::string& option) {
  const auto* const row = std::find_if(std::begin(kOptions), std::end(kOptions),
                                       [&](const OptionRow& known) { return known.name == option; });
  return row == std::end(kOptions) ? OptionRow{option, never, false} : *row;
}

std::string context_of(const OptionRow& option, const std::string& mode, const std::string& accuracy) {
  return option.is_of_both ? fmt::format("; {} and {}", mode, accuracy) : std::string();
}

}  // namespace

Mode parse_mode(pb::DetectionMode mode, const std::string& field) { return find_in(kModes, mode, field); }
pb::DetectionMode to_message(Mode mode) { return from_engine(kModes, mode); }

template <class Value, class Message>
std::optional<Value> parse(Message message, const std::string& field) {
  return to_engine(rows_of(Value{}), message, field);
}
template std::optional<Accuracy> parse(pb::Accuracy, const std::string&);
template std::optional<AdvanceMode> parse(pb::AdvanceMode, const std::string&);
template std::optional<Engine> parse(pb::BroadPhaseEngine, const std::string&);
template std::optional<MeshMotion> parse(pb::MeshMotion, const std::string&);
template std::optional<Report> parse(pb::Report, const std::string&);
template std::optional<Reuse> parse(pb::Reuse, const std::string&);

void check_max_accuracy(Accuracy accuracy, Accuracy max, const std::string& field) {
  if (accuracy <= max) return;
  throw LimitExceeded(field, fmt::format("{} is {}, above max_accuracy, {}", field, name_of(accuracy), name_of(max)));
}

void parse_format(const pb::SceneSpec& spec, SceneSpec& engine) {
  const std::string box = "spec.quantization_box";
  const bool is_quantized = spec.position_format() == pb::POSITION_FORMAT_Q16;
  if (is_quantized && !spec.has_quantization_box()) throw_invalid(box, "is missing, but POSITION_FORMAT_Q16 needs it");
  if (!is_quantized && spec.has_quantization_box())
    throw_invalid(box, "is set, but spec.position_format is not POSITION_FORMAT_Q16");
  if (!is_quantized)
    engine.scalar = to_engine(kFormats, spec.position_format(), "spec.position_format").value_or(Scalar::kF32);
  else
    engine.quantized_in = parse_box(spec.quantization_box(), box);
}

pb::PositionFormat format_of(const SceneSpec& engine) {
  return engine.quantized_in ? pb::POSITION_FORMAT_Q16 : from_engine(kFormats, engine.scalar);
}

// What the level does not compute is left out of each answer: a frame may override the level, but not the mode.
OutputFields parse_fields(const pb::SceneSpec& spec, Mode mode) {
  OutputFields fields{{ContactField::kElements, ContactField::kToi, ContactField::kDistance, ContactField::kFlags},
                      true};
  if (!spec.fields().empty()) fields = {};
  for (int i = 0; i < spec.fields_size(); ++i) {
    const auto asked = find_in(kFields, spec.fields(i), fmt::format("spec.fields[{}]", i));
    if (const auto* column = std::get_if<ContactField>(&asked))
      fields.columns = fields.columns.with(*column);
    else
      fields.*std::get<bool OutputFields::*>(asked) = true;
  }
  if (mode == Mode::kDcd) fields.columns = fields.columns.without(ContactField::kToi);
  return fields;
}

pb::Accuracy to_message(Accuracy accuracy) { return from_engine(kAccuracies, accuracy); }
pb::Report to_message(Report report) { return from_engine(kReports, report); }
pb::MeshMotion to_message(MeshMotion motion) { return from_engine(kMotions, motion); }
pb::BroadPhaseEngine to_message(Engine engine) { return from_engine(kEngines, engine); }
pb::BroadPhaseReason to_message(EngineReason reason) { return from_engine(kReasons, reason); }
pb::Reuse to_message(Reuse reuse) { return from_engine(kReuses, reuse); }
pb::ListUse to_message(ListUse use) { return from_engine(kListUses, use); }
pb::ReuseReason to_message(ReuseReason reason) { return from_engine(kReuseReasons, reason); }

std::string_view label_of(Engine engine) {
  static const auto labels = labels_of(*pb::BroadPhaseEngine_descriptor(), "BROAD_PHASE_ENGINE_");
  return labels.at(to_message(engine));
}
std::string_view label_of(EngineReason reason) {
  static const auto labels = labels_of(*pb::BroadPhaseReason_descriptor(), "BROAD_PHASE_REASON_");
  return labels.at(to_message(reason));
}

void fill_fields(const OutputFields& fields, pb::SceneSpec* out) {
  for (const auto& [field, asked] : kFields) {
    const auto* column = std::get_if<ContactField>(&asked);
    if (column ? fields.columns.has(*column) : fields.*std::get<bool OutputFields::*>(asked)) out->add_fields(field);
  }
}

InvalidInput with_path_in(const InvalidInput& error, const pb::SceneSpec& spec) {
  const OptionPath path = path_in(spec, error.field());
  return {path.field, renamed(error, path.shown)};
}

void check_scene_options(const SceneSpec& engine, const pb::SceneSpec& spec) try {
  check_options(engine);
} catch (const InvalidInput& e) {
  const InvalidInput refusal = with_path_in(e, spec);
  const std::string accuracy = "spec.accuracy is " + name_of(engine.accuracy);
  throw InvalidInput(refusal.field(),
                     refusal.what() + context_of(row_of(e.field()), "spec.mode is " + name_of(engine.mode), accuracy));
}

// The scene's own options are sound: unless the frame overrides the refused one, its accuracy is what does not fit.
void check_frame_options(const SceneSpec& scene, const FrameInput& frame) try {
  check_options_of_frame(scene, frame);
} catch (const InvalidInput& e) {
  const OptionRow refused = row_of(e.field());
  const bool is_own = refused.is_frames(frame);
  const bool is_mode = !is_own && frame.mode && !frame.accuracy;
  const std::string field = is_own ? frame_path(e.field()) : is_mode ? "frame.mode" : "frame.accuracy";
  const std::string value = name_of(frame.accuracy.value_or(scene.accuracy));
  const auto entry = entry_of(e.field());
  const std::string option = entry ? entry->name + " of " + entry->list : spec_path(e.field());
  if (!is_own)
    throw InvalidInput(field,
                       fmt::format("{} is {}: {}", field, is_mode ? name_of(*frame.mode) : value, renamed(e, option)));
  const std::string accuracy = fmt::format("{}.accuracy is {}", frame.accuracy ? "frame" : "spec", value);
  const std::string mode = frame.mode ? "frame.mode is " + name_of(*frame.mode) : "spec.mode is " + name_of(scene.mode);
  throw InvalidInput(field, renamed(e, field) + context_of(refused, mode, accuracy));
}

}  // namespace collided::server
