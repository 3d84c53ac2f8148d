// Scenes between the protocol and the engine.
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <set>

#include "server/convert/convert.hpp"
#include "server/convert/convert_level.hpp"
#include "server/convert/refuse.hpp"

namespace collided::server {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian and is copied as it is");

constexpr size_t kMaxNameBytes = 128;
constexpr size_t kTriangleBytes = 12;

// What is wrong with a triangle; empty if nothing is.
std::string check_triangle(const TriangleCorners& t, uint32_t vertex_count) {
  for (const uint32_t vertex : t)
    if (vertex >= vertex_count) return fmt::format("has vertex {}, but the mesh has {} vertices", vertex, vertex_count);
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
    return fmt::format("has a corner twice: {} {} {}", t[0], t[1], t[2]);
  return {};
}

Backend parse_backend(pb::Backend wanted, const SceneDefaults& defaults) {
  if (wanted == pb::BACKEND_UNSPECIFIED)
    wanted = defaults.backend == "cpu"    ? pb::BACKEND_CPU
             : defaults.backend == "cuda" ? pb::BACKEND_CUDA
                                          : pb::BACKEND_AUTO;
  if (wanted == pb::BACKEND_AUTO) return defaults.cuda ? Backend::kCuda : Backend::kCpu;
  if (wanted == pb::BACKEND_CPU) return Backend::kCpu;
  if (wanted != pb::BACKEND_CUDA)
    throw_unknown("spec.backend", wanted, {pb::BACKEND_AUTO, pb::BACKEND_CPU, pb::BACKEND_CUDA});
  if (!defaults.cuda)
    throw FailedPrecondition("spec.backend", "spec.backend is BACKEND_CUDA, but this daemon has no usable CUDA device");
  return Backend::kCuda;
}

Mode parse_mode(pb::DetectionMode mode) {
  if (mode == pb::DETECTION_MODE_DCD) return Mode::kDcd;
  if (mode == pb::DETECTION_MODE_CCD) return Mode::kCcd;
  throw_unknown("spec.mode", mode, {pb::DETECTION_MODE_DCD, pb::DETECTION_MODE_CCD});
}

Scalar parse_format(pb::PositionFormat format) {
  if (format == pb::POSITION_FORMAT_UNSPECIFIED || format == pb::POSITION_FORMAT_F32) return Scalar::kF32;
  if (format == pb::POSITION_FORMAT_F64) return Scalar::kF64;
  if (format == pb::POSITION_FORMAT_Q16) throw_not_served("spec.position_format", "POSITION_FORMAT_Q16");
  throw_unknown("spec.position_format", format, {pb::POSITION_FORMAT_F32, pb::POSITION_FORMAT_F64});
}

void add_kind(const std::string& path, pb::ContactKind kind, SceneSpec& engine) {
  switch (kind) {
    case pb::CONTACT_KIND_VERTEX_TRIANGLE:
      engine.vertex_triangle = true;
      return;
    case pb::CONTACT_KIND_EDGE_EDGE:
      engine.edge_edge = true;
      return;
    case pb::CONTACT_KIND_TRIANGLE_TRIANGLE:
      if (engine.mode != Mode::kDcd && engine.accuracy != Accuracy::kCandidates)
        throw_invalid(path,
                      "is CONTACT_KIND_TRIANGLE_TRIANGLE, which needs DETECTION_MODE_DCD or ACCURACY_CANDIDATES, but "
                      "spec.mode is DETECTION_MODE_CCD and spec.accuracy is " +
                          pb::Accuracy_Name(to_message(engine.accuracy)));
      engine.triangle_triangle = true;
      return;
    default:
      throw_unknown(path, kind,
                    {pb::CONTACT_KIND_VERTEX_TRIANGLE, pb::CONTACT_KIND_EDGE_EDGE, pb::CONTACT_KIND_TRIANGLE_TRIANGLE});
  }
}

void parse_kinds(const pb::SceneSpec& spec, SceneSpec& engine) {
  if (spec.kinds().empty()) return;
  engine.vertex_triangle = engine.edge_edge = false;
  for (int i = 0; i < spec.kinds_size(); ++i) add_kind(fmt::format("spec.kinds[{}]", i), spec.kinds(i), engine);
}

void add_field(const std::string& path, pb::ContactField field, OutputFields& fields) {
  switch (field) {
    case pb::CONTACT_FIELD_ELEMENTS:
      fields.elements = true;
      return;
    case pb::CONTACT_FIELD_STENCIL:
      fields.stencils = true;
      return;
    case pb::CONTACT_FIELD_TOI:
      fields.toi = true;
      return;
    case pb::CONTACT_FIELD_DISTANCE:
      fields.distance = true;
      return;
    case pb::CONTACT_FIELD_WEIGHTS:
      fields.weights = true;
      return;
    case pb::CONTACT_FIELD_FLAGS:
      fields.flags = true;
      return;
    case pb::CONTACT_FIELD_NORMAL:
      throw_not_served(path, "CONTACT_FIELD_NORMAL");
    default:
      throw_unknown(path, field,
                    {pb::CONTACT_FIELD_ELEMENTS, pb::CONTACT_FIELD_STENCIL, pb::CONTACT_FIELD_TOI,
                     pb::CONTACT_FIELD_DISTANCE, pb::CONTACT_FIELD_WEIGHTS, pb::CONTACT_FIELD_FLAGS});
  }
}

// What the level does not compute is left out of each answer: a frame may override the level, but not the mode.
OutputFields parse_fields(const pb::SceneSpec& spec, Mode mode) {
  OutputFields fields;
  for (int i = 0; i < spec.fields_size(); ++i) add_field(fmt::format("spec.fields[{}]", i), spec.fields(i), fields);
  if (spec.fields().empty())
    fields = {.elements = true, .stencils = true, .toi = true, .distance = true, .flags = true};
  fields.toi &= mode == Mode::kCcd;
  return fields;
}

bool parse_static(pb::MeshMotion motion, const std::string& field) {
  if (motion == pb::MESH_MOTION_UNSPECIFIED || motion == pb::MESH_MOTION_DEFORMABLE) return false;
  if (motion == pb::MESH_MOTION_STATIC) return true;
  if (motion == pb::MESH_MOTION_RIGID) throw_not_served(field, "MESH_MOTION_RIGID");
  throw_unknown(field, motion, {pb::MESH_MOTION_DEFORMABLE, pb::MESH_MOTION_STATIC});
}

uint64_t inline_triangles(const pb::MeshSpec& mesh) { return mesh.triangles().size() / kTriangleBytes; }

uint64_t total_triangles(const pb::MeshSpec& mesh) {
  return std::max<uint64_t>(mesh.triangle_count(), inline_triangles(mesh));
}

MeshSpec parse_mesh(const pb::MeshSpec& mesh, const std::string& path) {
  if (mesh.name().empty() || mesh.name().size() > kMaxNameBytes)
    throw_invalid(path + ".name",
                  fmt::format("has {} bytes, but must have 1 to {}", mesh.name().size(), kMaxNameBytes));
  if (mesh.vertex_count() < 3)
    throw_invalid(path + ".vertex_count", fmt::format("is {}, but must be at least 3", mesh.vertex_count()));
  MeshSpec out;
  out.vertex_count = mesh.vertex_count();
  out.is_static = parse_static(mesh.motion(), path + ".motion");
  out.groups = mesh.groups() ? mesh.groups() : 1;
  out.collide_mask = mesh.collide_mask() ? mesh.collide_mask() : ~0u;
  out.self_contacts = !mesh.no_self_contacts();
  out.triangles.reserve(inline_triangles(mesh));
  for_each_triangle(mesh.triangles(), out.vertex_count, {path + ".triangles"},
                    [&](const TriangleCorners& triangle) { out.triangles.push_back(triangle); });
  if (total_triangles(mesh) == 0)
    throw_invalid(path + ".triangles", "is empty and triangle_count is 0, but a mesh needs a triangle");
  if (mesh.triangle_count() > 0 && mesh.triangle_count() < out.triangles.size())
    throw_invalid(
        path + ".triangle_count",
        fmt::format("is {}, but {}.triangles already has {}: it is the total, with those that UploadMesh brings",
                    mesh.triangle_count(), path, out.triangles.size()));
  return out;
}

struct SceneSize {
  uint64_t vertices = 0, triangles = 0;
};

void check_total(const char* what, uint64_t total, uint64_t limit) {
  if (total > limit)
    throw LimitExceeded("spec.meshes",
                        fmt::format("spec.meshes has {} {} in all, more than max_{}, {}", total, what, what, limit));
}

// Sizes are checked before any array is copied.
SceneSize check_sizes(const pb::SceneSpec& spec, const Limits& limits) {
  if (spec.meshes().empty()) throw_invalid("spec.meshes", "is empty, but a scene needs a mesh");
  if (spec.meshes_size() > kMaxMeshes)
    throw LimitExceeded("spec.meshes", fmt::format("spec.meshes has {} meshes, more than the limit of {}",
                                                   spec.meshes_size(), kMaxMeshes));
  SceneSize size;
  for (const auto& mesh : spec.meshes()) {
    size.vertices += mesh.vertex_count();
    size.triangles += total_triangles(mesh);
  }
  check_total("vertices", size.vertices, limits.max_vertices);
  check_total("triangles", size.triangles, limits.max_triangles);
  return size;
}

// A scene's first frame brings all its positions at once, and a frame is one message.
void check_first_frame(uint64_t vertices, Scalar scalar, const SceneDefaults& defaults) {
  const uint64_t bytes = vertices * (scalar == Scalar::kF64 ? 24 : 12), limit = defaults.limits.max_message_bytes;
  if (defaults.local_socket || bytes < limit) return;
  throw LimitExceeded(
      "spec.meshes", fmt::format("spec.meshes has {} vertices, whose positions, {} bytes, come with the first frame in "
                                 "one message, but max_message_bytes (max-message-mb) is {}, and this daemon has no "
                                 "local socket",
                                 vertices, bytes, limit));
}

// The least that the scene will hold, so that none is begun that can never have a frame.
uint64_t check_budget(const SceneSpec& engine, const SceneSize& size, bool is_asked) {
  const uint64_t need = min_scene_bytes(engine, size.vertices, size.triangles);
  if (need > engine.memory_budget)
    throw LimitExceeded(
        "spec.memory_budget_bytes",
        fmt::format("spec.memory_budget_bytes is {}{}, but the {} vertices and {} triangles of spec.meshes need at "
                    "least {} bytes",
                    engine.memory_budget, is_asked ? "" : " (max_scene_bytes)", size.vertices, size.triangles, need));
  return need;
}

void parse_meshes(const pb::SceneSpec& spec, ScenePlan& plan) {
  std::set<std::string> names;
  for (int i = 0; i < spec.meshes_size(); ++i) {
    const auto& mesh = spec.meshes(i);
    const std::string path = fmt::format("spec.meshes[{}]", i);
    plan.engine.meshes.push_back(parse_mesh(mesh, path));
    plan.meshes.push_back({mesh.name(), total_triangles(mesh), total_triangles(mesh) - inline_triangles(mesh)});
    if (!names.insert(mesh.name()).second)
      throw_invalid(path + ".name", fmt::format("is \"{}\", which an earlier mesh has", mesh.name()));
  }
}

uint64_t parse_budget(uint64_t budget, uint64_t limit) {
  if (budget > limit)
    throw LimitExceeded("spec.memory_budget_bytes",
                        fmt::format("spec.memory_budget_bytes is {}, more than max_scene_bytes, {}", budget, limit));
  return budget ? budget : limit;
}

}  // namespace

void for_each_triangle(std::string_view bytes, uint32_t vertex_count, const TrianglePath& path,
                       const std::function<void(const TriangleCorners&)>& take) {
  if (bytes.size() % kTriangleBytes)
    throw_invalid(path.field, fmt::format("has {} bytes, which is no multiple of {}", bytes.size(), kTriangleBytes));
  for (size_t i = 0; i < bytes.size() / kTriangleBytes; ++i) {
    TriangleCorners triangle;
    std::memcpy(triangle.data(), bytes.data() + i * kTriangleBytes, kTriangleBytes);
    if (const auto wrong = check_triangle(triangle, vertex_count); !wrong.empty())
      throw_invalid(fmt::format("{}[{}]", path.field, path.first + i), wrong);
    take(triangle);
  }
}

namespace {

// Hashes what is written, block by block, without a copy of it all.
class HashOfBytes final : public google::protobuf::io::CopyingOutputStream {
 public:
  bool Write(const void* bytes, int size) override {
    const std::string_view block(static_cast<const char*>(bytes), static_cast<size_t>(size));
    hash_ = hash_ * 0x9e3779b97f4a7c15u + std::hash<std::string_view>{}(block);
    return true;
  }
  uint64_t hash() const { return hash_; }

 private:
  uint64_t hash_ = 0;
};

// Equal requests repeat each other; the lease may differ.
uint64_t fingerprint(const pb::SceneSpec& spec) {
  HashOfBytes hash;
  {
    google::protobuf::io::CopyingOutputStreamAdaptor blocks(&hash);
    google::protobuf::io::CodedOutputStream coded(&blocks);
    coded.SetSerializationDeterministic(true);
    spec.SerializeToCodedStream(&coded);
  }
  return hash.hash();
}

double parse_lease(double seconds, const Limits& limits) {
  if (!(seconds >= 0)) throw_invalid("lease_seconds", fmt::format("is {}, but must be 0 or more", seconds));
  if (seconds > limits.max_lease_seconds)
    throw LimitExceeded("lease_seconds", fmt::format("lease_seconds is {}, more than max_lease_seconds, {}", seconds,
                                                     limits.max_lease_seconds));
  return seconds > 0 ? seconds : limits.lease_seconds;
}

// One that nobody asks for is as high as it may be, up to CERTIFIED.
Accuracy parse_scene_accuracy(pb::Accuracy wanted, Accuracy most) {
  const auto asked = parse_accuracy(wanted, "spec.accuracy");
  if (asked) check_most(*asked, most, "spec.accuracy");
  return asked.value_or(std::min(Accuracy::kCertified, most));
}

ScenePlan parse_plan(const pb::SceneSpec& spec, const SceneDefaults& defaults) {
  if (spec.display_name().size() > kMaxNameBytes)
    throw_invalid("spec.display_name",
                  fmt::format("has {} bytes, more than {}", spec.display_name().size(), kMaxNameBytes));
  ScenePlan plan;
  plan.display_name = spec.display_name();
  SceneSpec& engine = plan.engine;
  engine.mode = parse_mode(spec.mode());
  engine.accuracy = parse_scene_accuracy(spec.accuracy(), defaults.limits.client.max_accuracy);
  engine.scalar = parse_format(spec.position_format());
  engine.thickness = parse_length(spec.thickness(), "spec.thickness");
  engine.delta = parse_length(spec.delta(), "spec.delta");
  engine.report = parse_report(spec.report(), "spec.report").value_or(Report::kAll);
  engine.engine = parse_engine(spec.broad_phase_engine(), "spec.broad_phase_engine");
  parse_kinds(spec, engine);
  check_levels(engine, {});
  plan.fields = parse_fields(spec, engine.mode);
  engine.weights = plan.fields.weights;
  engine.memory_budget = parse_budget(spec.memory_budget_bytes(), defaults.limits.max_scene_bytes);
  engine.threads = defaults.threads;
  const SceneSize size = check_sizes(spec, defaults.limits);
  check_first_frame(size.vertices, engine.scalar, defaults);
  plan.min_bytes = check_budget(engine, size, spec.memory_budget_bytes() > 0);
  parse_meshes(spec, plan);
  engine.backend = parse_backend(spec.backend(), defaults);
  return plan;
}

}  // namespace

SceneRequest parse_scene(const pb::CreateSceneRequest& request, const SceneDefaults& defaults) {
  constexpr size_t kMaxRequestIdBytes = 64;
  if (request.request_id().size() > kMaxRequestIdBytes)
    throw_invalid("request_id",
                  fmt::format("has {} bytes, more than {}", request.request_id().size(), kMaxRequestIdBytes));
  const double lease = parse_lease(request.lease_seconds(), defaults.limits);
  return {parse_plan(request.spec(), defaults), request.request_id(), fingerprint(request.spec()), lease};
}

}  // namespace collided::server
