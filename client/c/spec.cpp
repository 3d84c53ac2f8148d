#include "client/c/spec.hpp"

#include "gpu/detector.hpp"

namespace collided::c {
namespace {

// Indexed by the enumerators of collided.h.
constexpr Mode kModes[] = {Mode::kCcd, Mode::kDcd, Mode::kCcd, Mode::kBoth};
constexpr Accuracy kAccuracies[] = {Accuracy::kCertified, Accuracy::kCandidates, Accuracy::kFast,
                                    Accuracy::kGuarded,   Accuracy::kCertified,  Accuracy::kExact};
constexpr Report kReports[] = {Report::kAll, Report::kAll, Report::kEarliestOnly, Report::kAnyHit};
constexpr AdvanceMode kAdvanceModes[] = {AdvanceMode::kAllOrOne, AdvanceMode::kAllOrOne, AdvanceMode::kPerMesh,
                                         AdvanceMode::kPerVertex};
constexpr Scalar kScalars[] = {Scalar::kF32, Scalar::kF32, Scalar::kF64, Scalar::kF32};
constexpr MeshMotion kMotions[] = {MeshMotion::kDeformable, MeshMotion::kDeformable, MeshMotion::kStatic,
                                   MeshMotion::kRigid};
constexpr Engine kEngines[] = {Engine::kAuto,     Engine::kOctree,      Engine::kTopDown,
                               Engine::kBottomUp, Engine::kUniformGrid, Engine::kTwoLevelGrid,
                               Engine::kLbvh,     Engine::kVss,         Engine::kAllPairs};
constexpr Reuse kReuses[] = {Reuse::kAuto, Reuse::kOn, Reuse::kOff};

/// `count` times N numbers.
template <class T>
std::vector<T> copy_array(const uint32_t* array, uint64_t count, const std::string& field,
                          const std::string& count_field) {
  check_array(array, count, field, count_field);
  std::vector<T> out(count);
  if (count > 0) std::memcpy(out.data(), array, count * sizeof(T));
  return out;
}

MeshSpec parse_mesh(const collided_mesh& from, const std::string& field) {
  const auto array_of = [&]<class T>(const uint32_t* array, uint64_t count, const char* name) {
    const std::string plural = name;
    return copy_array<T>(array, count, field + "." + plural + "s", field + "." + plural + "_count");
  };
  check_reserved(from.reserved, field + ".reserved");
  MeshSpec mesh;
  mesh.vertex_count = from.vertex_count;
  mesh.triangles =
      array_of.template operator()<std::array<uint32_t, 3>>(from.triangles, from.triangle_count, "triangle");
  mesh.edges = array_of.template operator()<std::array<uint32_t, 2>>(from.edges, from.edge_count, "edge");
  mesh.points = array_of.template operator()<uint32_t>(from.points, from.point_count, "point");
  mesh.motion = choose(kMotions, from.motion, field + ".motion");
  if (from.groups != 0) mesh.groups = from.groups;
  if (from.collide_mask != 0) mesh.collide_mask = from.collide_mask;
  mesh.self_contacts = from.no_self_contacts == 0;
  mesh.excluded_rings = from.excluded_rings;
  mesh.excludes_rest_pairs = from.excludes_rest_pairs != 0;
  mesh.half_thickness = from.half_thickness;
  check_reserved(from.reserved2, field + ".reserved2");
  mesh.solid = from.solid != 0;
  return mesh;
}

Device parse_place(const char* text) {
  const std::string name = text == nullptr ? "auto" : text;
  if (name == "auto") return {cuda_available() ? Backend::kCuda : Backend::kCpu};
  const std::optional<Device> device = parse_device(name);
  if (!device)
    throw InvalidInput("device", "device is \"" + name.substr(0, 64) +
                                     "\"; it must be \"auto\", \"cpu\", \"cuda\", or \"cuda:\" and a number");
  return *device;
}

void check_mask(uint32_t mask, uint32_t all, const std::string& field) {
  if ((mask & ~all) != 0)
    throw InvalidInput(field,
                       field + " is " + std::to_string(mask) + "; its bits must be among " + std::to_string(all));
}

void parse_kinds(uint32_t mask, SceneSpec& engine) {
  check_mask(mask, (1u << kContactKinds) - 1, "kinds");
  if (mask == 0) return;
  for_each_kind([&](ContactKind kind, bool& wanted) { wanted = (mask >> static_cast<int>(kind) & 1) != 0; },
                engine.kinds);
}

constexpr std::pair<uint32_t, ContactField> kFields[] = {
    {COLLIDED_FIELDS_ELEMENTS, ContactField::kElements},
    {COLLIDED_FIELDS_TOI, ContactField::kToi},
    {COLLIDED_FIELDS_DISTANCE, ContactField::kDistance},
    {COLLIDED_FIELDS_WEIGHTS, ContactField::kWeights},
    {COLLIDED_FIELDS_NORMALS, ContactField::kNormals},
    {COLLIDED_FIELDS_FLAGS, ContactField::kFlags},
    {COLLIDED_FIELDS_FEATURES, ContactField::kFeatures},
    {COLLIDED_FIELDS_SIGNED_DISTANCE, ContactField::kSignedDistance}};

void parse_fields(uint32_t mask, Spec& spec) {
  constexpr uint32_t kAll = 2 * COLLIDED_FIELDS_PAIR_STATES - 1;
  constexpr uint32_t kOnlyIfNamed = COLLIDED_FIELDS_WEIGHTS | COLLIDED_FIELDS_NORMALS | COLLIDED_FIELDS_FEATURES |
                                    COLLIDED_FIELDS_SIGNED_DISTANCE | COLLIDED_FIELDS_PAIR_STATES;
  check_mask(mask, kAll, "fields");
  if (mask == 0) mask = kAll & ~kOnlyIfNamed;
  for (const auto& [bit, field] : kFields)
    if ((mask & bit) != 0) spec.fields = spec.fields.with(field);
  spec.stencils = (mask & COLLIDED_FIELDS_STENCILS) != 0;
  spec.engine.fields = spec.fields;
  spec.engine.pair_states = (mask & COLLIDED_FIELDS_PAIR_STATES) != 0;
}

void parse_format(const collided_scene_spec& from, SceneSpec& engine) {
  engine.scalar = choose(kScalars, from.position_format, "position_format");
  if ((from.position_format == COLLIDED_Q16) != (from.quantized_in != nullptr))
    throw InvalidInput("quantized_in", std::string("quantized_in is ") + (from.quantized_in ? "given" : "null") +
                                           ", but position_format is " + std::to_string(from.position_format) +
                                           ": Q16 (" + std::to_string(COLLIDED_Q16) + ") and a box go together");
  if (from.quantized_in == nullptr) return;
  PositionBox box;
  std::memcpy(box.lower.data(), from.quantized_in, sizeof(box.lower));
  std::memcpy(box.upper.data(), from.quantized_in + 3, sizeof(box.upper));
  engine.quantized_in = box;
}

uint64_t parse_expected(uint64_t contacts) {
  if (contacts > kMaxListLength)
    throw InvalidInput("expected_contacts", "expected_contacts is " + std::to_string(contacts) + ", the limit is " +
                                                std::to_string(kMaxListLength));
  return contacts;
}

int parse_threads(int32_t threads) {
  constexpr int32_t kMax = 4096;
  if (threads > kMax)
    throw InvalidInput("threads", "threads is " + std::to_string(threads) + ", the limit is " + std::to_string(kMax));
  return threads;
}

/// Rows of [R | t].
std::span<const std::byte> bytes_of(const double* pose) {
  constexpr size_t kNumbers = 12;
  return pose == nullptr ? std::span<const std::byte>{} : std::as_bytes(std::span(pose, kNumbers));
}

std::span<const std::byte> bytes_of(const void* array, uint64_t bytes, const std::string& field) {
  if (bytes > 0 && array == nullptr)
    throw InvalidInput(field, field + " is null, but " + field + "_bytes is " + std::to_string(bytes));
  if (array != nullptr && bytes == 0)
    throw InvalidInput(field + "_bytes", field + "_bytes is 0, but " + field + " is given");
  return {static_cast<const std::byte*>(array), bytes};
}

MeshPositions parse_update(const collided_update& from, const std::string& field) {
  MeshPositions update;
  update.mesh = from.mesh;
  update.start = bytes_of(from.start, from.start_bytes, field + ".start");
  update.end = bytes_of(from.end, from.end_bytes, field + ".end");
  check_array(from.indices, from.index_count, field + ".indices", field + ".index_count");
  update.is_sparse = from.is_sparse != 0;
  update.indices = std::as_bytes(std::span(from.indices, from.index_count));
  update.transform = bytes_of(from.transform);
  update.start_transform = bytes_of(from.start_transform);
  return update;
}

template <class T, size_t N>
std::optional<T> choose_for_frame(const T (&values)[N], int32_t enumerator, const std::string& field) {
  const T value = choose(values, enumerator, field);
  return enumerator == 0 ? std::nullopt : std::optional<T>(value);
}

AdvanceMode parse_advance_mode(const collided_frame& from) {
  const AdvanceMode mode = choose(kAdvanceModes, from.advance_mode, "advance_mode");
  if (from.advance_mode != 0 && from.advance == 0)
    throw InvalidInput("advance_mode", "advance_mode is " + std::to_string(from.advance_mode) + ", but advance is 0");
  return mode;
}

std::optional<double> optional_of(const double* number) {
  return number == nullptr ? std::nullopt : std::optional<double>(*number);
}

}  // namespace

Spec parse_spec(const collided_scene_spec* pointer) {
  const collided_scene_spec from = read_structure(pointer, "spec");
  check_reserved(from.reserved, "reserved");
  Spec spec;
  SceneSpec& engine = spec.engine;
  engine.mode = choose(kModes, from.mode, "mode");
  engine.accuracy = choose(kAccuracies, from.accuracy, "accuracy");
  engine.report = choose(kReports, from.report, "report");
  engine.engine = choose(kEngines, from.broad_phase_engine, "broad_phase_engine");
  engine.reuse = choose(kReuses, from.reuse, "reuse");
  parse_format(from, engine);
  engine.thickness = from.thickness;
  engine.delta = from.delta;
  engine.min_separation = from.min_separation;
  parse_kinds(from.kinds, engine);
  parse_fields(from.fields, spec);
  engine.memory_budget = from.memory_budget;
  engine.expected[ListLengths::kContacts] = parse_expected(from.expected_contacts);
  engine.threads = parse_threads(from.threads);
  check_array(from.meshes, from.mesh_count, "meshes", "mesh_count");
  for (uint64_t i = 0; i < from.mesh_count; ++i)
    engine.meshes.push_back(parse_mesh(read_element(from.meshes, i, "meshes"), "meshes[" + std::to_string(i) + "]"));
  engine.excluded_meshes = copy_array<std::array<uint32_t, 2>>(from.excluded_meshes, from.excluded_mesh_count,
                                                               "excluded_meshes", "excluded_mesh_count");
  engine.rest_distance = from.rest_distance;
  engine.device = parse_place(from.device);
  return spec;
}

FrameInput parse_frame(const collided_frame* pointer) {
  const collided_frame from = read_structure(pointer, "frame");
  FrameInput frame;
  check_array(from.updates, from.update_count, "updates", "update_count");
  for (uint64_t i = 0; i < from.update_count; ++i)
    frame.updates.push_back(
        parse_update(read_element(from.updates, i, "updates"), "updates[" + std::to_string(i) + "]"));
  frame.mode = choose_for_frame(kModes, from.mode, "mode");
  frame.accuracy = choose_for_frame(kAccuracies, from.accuracy, "accuracy");
  frame.report = choose_for_frame(kReports, from.report, "report");
  frame.ignore_separating = from.ignore_separating != 0;
  frame.advance = from.advance != 0;
  frame.advance_mode = parse_advance_mode(from);
  frame.limits = from.limits != 0;
  frame.trial = from.trial != 0;
  frame.delta = optional_of(from.delta);
  frame.start_fraction = optional_of(from.start_fraction);
  frame.stream = from.stream;
  const std::span<const std::byte> room = bytes_of(from.room, from.room_bytes, "room");
  frame.room.memory = {static_cast<std::byte*>(from.room), room.size()};
  if (from.cancelled != nullptr)
    frame.cancelled = [ask = from.cancelled, context = from.cancelled_context] { return ask(context) != 0; };
  return frame;
}

int32_t enumerator_of(Engine engine) {
  return static_cast<int32_t>(std::ranges::find(kEngines, engine) - std::begin(kEngines));
}

}  // namespace collided::c
