// Records a scene that others drive, as far as a watch shows it.

#include "client/cli/recording/live.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>

#include "client/app/input/frame_files.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/options/values.hpp"
#include "client/cpp/positions.hpp"

namespace collided::cli {

namespace {

constexpr uint64_t kMaxWatchedBytes = 2 << 20;  // WatchSceneRequest.vertex_stride
constexpr uint32_t kMaxWatchedContacts = 8192;  // of a kind, WatchSceneRequest.max_contacts_per_kind

[[noreturn]] void refuse(const std::string& why) { throw std::runtime_error("--record: " + why); }

/// Elements of all files, with vertices numbered across them.
scenes::Mesh read_together(const std::vector<std::string>& files) {
  scenes::Mesh all;
  for (const std::string& file : files) {
    const scenes::Mesh mesh = read_frame(file).mesh;
    const uint32_t base = all.vertex_count;
    for (const auto& t : mesh.triangles) all.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    for (const auto& e : mesh.edges) all.edges.push_back({base + e[0], base + e[1]});
    for (const uint32_t p : mesh.points) all.points.push_back(base + p);
    all.vertex_count += mesh.vertex_count;
  }
  return all;
}

/// Vertices, triangles, loose edges and loose points.
using Numbers = std::array<uint64_t, 4>;

Numbers numbers_of(const v1::SceneSpec& spec) {
  Numbers sum{};
  for (const v1::MeshSpec& mesh : spec.meshes()) {
    sum[0] += mesh.vertex_count();
    sum[1] += mesh.triangle_count();
    sum[2] += mesh.edge_count();
    sum[3] += mesh.point_count();
  }
  return sum;
}

std::string text_of(const Numbers& n) {
  return std::to_string(n[0]) + " vertices, " + std::to_string(n[1]) + " triangles, " + std::to_string(n[2]) +
         " loose edges and " + std::to_string(n[3]) + " loose points";
}

/// The next elements of a mesh, numbered within it.
template <class Element>
std::vector<Element> take(const std::vector<Element>& all, size_t& at, uint64_t count, uint32_t base,
                          uint32_t vertices) {
  std::vector<Element> out(all.begin() + static_cast<ptrdiff_t>(at), all.begin() + static_cast<ptrdiff_t>(at + count));
  at += count;
  const auto number_within = [&](uint32_t& vertex) {
    if (vertex < base || vertex - base >= vertices)
      refuse("the mesh files have other meshes than the scene: an element has vertex " + std::to_string(vertex) +
             ", which is not of its mesh");
    vertex -= base;
  };
  for (Element& element : out) {
    if constexpr (std::is_same_v<Element, uint32_t>)
      number_within(element);
    else
      for (uint32_t& vertex : element) number_within(vertex);
  }
  return out;
}

bool has_motion(const v1::SceneSpec& spec) { return spec.mode() != v1::DETECTION_MODE_DCD; }

/// What in a scene's spec makes a replay find something else than the scene did.
std::vector<std::string> differences(const v1::SceneSpec& spec) {
  std::vector<std::string> out;
  const auto any_mesh = [&](const auto& is) { return std::any_of(spec.meshes().begin(), spec.meshes().end(), is); };
  if (any_mesh([](const v1::MeshSpec& mesh) { return mesh.motion() == v1::MESH_MOTION_RIGID; }))
    out.push_back("rigid meshes are recorded as deformable ones, whose vertices move straight instead of on screws");
  if (any_mesh([](const v1::MeshSpec& mesh) { return mesh.exclude_rest_pairs(); }))
    out.push_back("pairs at rest are those of the first recorded frame, not of the scene's first");
  if (spec.mode() == v1::DETECTION_MODE_DCD_AND_CCD) out.push_back("every frame is replayed as ccd");
  return out;
}

v1::SceneSpec spec_without_meshes(v1::SceneSpec spec) {
  spec.clear_meshes();
  return spec;
}

const v1::Scene& check_scene(const v1::Scene& scene) {
  const v1::SceneSpec& spec = scene.spec();
  if (client::is_quantized(spec.position_format()))
    refuse("a watch shows positions of " + name_of(spec.position_format()) + " scenes decoded, not as they were sent");
  const uint64_t bytes = scene.vertex_count() * client::position_bytes(spec.position_format());
  if (bytes > kMaxWatchedBytes)
    refuse("the scene's positions take " + std::to_string(bytes) + " bytes; a watch shows all up to " +
           std::to_string(kMaxWatchedBytes));
  return scene;
}

}  // namespace

SceneElements::SceneElements(const v1::SceneSpec& spec, const std::vector<std::string>& files) {
  const scenes::Mesh all = read_together(files);
  const Numbers found{all.vertex_count, all.triangles.size(), all.edges.size(), all.points.size()};
  if (found != numbers_of(spec))
    refuse("the mesh files have " + text_of(found) + "; the scene has " + text_of(numbers_of(spec)));
  size_t triangle = 0, edge = 0, point = 0;
  uint32_t base = 0;
  for (const v1::MeshSpec& mesh : spec.meshes()) {
    const uint32_t vertices = mesh.vertex_count();
    meshes_.push_back({.name = mesh.name(),
                       .vertex_count = vertices,
                       .triangles = take(all.triangles, triangle, mesh.triangle_count(), base, vertices),
                       .is_static = mesh.motion() == v1::MESH_MOTION_STATIC,
                       .edges = take(all.edges, edge, mesh.edge_count(), base, vertices),
                       .points = take(all.points, point, mesh.point_count(), base, vertices)});
    base += vertices;
  }
  inputs_ = mesh_inputs(meshes_);
  for (int i = 0; i < spec.meshes_size(); ++i) {
    const v1::MeshSpec& mesh = spec.meshes(i);
    client::MeshInput& input = inputs_[static_cast<size_t>(i)];
    input.exclude_rings = mesh.exclude_rings();
    input.exclude_rest_pairs = mesh.exclude_rest_pairs();
    input.groups = mesh.groups();
    input.collide_mask = mesh.collide_mask();
    input.half_thickness = mesh.half_thickness();
    input.solid = mesh.solid();
    // A rigid mesh is never tested with itself.
    input.no_self_contacts = mesh.no_self_contacts() || mesh.motion() == v1::MESH_MOTION_RIGID;
  }
}

LiveRecorder::LiveRecorder(const std::string& file, const v1::Scene& scene, const std::vector<std::string>& mesh_files)
    : file_(file),
      scene_(check_scene(scene)),
      writer_(file, spec_without_meshes(scene.spec()), SceneElements(scene.spec(), mesh_files).inputs()) {}

client::WatchOptions LiveRecorder::watch_options(const v1::Scene& scene) {
  check_scene(scene);
  client::WatchOptions options;
  options.max_contacts_per_kind = kMaxWatchedContacts;
  options.vertex_stride = 1;
  options.meshes.resize(static_cast<size_t>(scene.spec().meshes_size()));
  std::iota(options.meshes.begin(), options.meshes.end(), 0u);
  return options;
}

bool LiveRecorder::add(const client::WatchedFrame& frame) {
  if (frame.edit_count != scene_.edit_count()) {
    was_edited_ = true;
    return false;
  }
  v1::Frame recorded;
  recorded.set_frame_id(frame.frame_id);
  for (const v1::VertexSample& sample : frame.positions) {
    if (sample.mesh() >= static_cast<uint32_t>(scene_.spec().meshes_size()))
      refuse("the daemon sent positions of mesh " + std::to_string(sample.mesh()) + "; the scene has " +
             std::to_string(scene_.spec().meshes_size()) + " meshes");
    const v1::MeshSpec& mesh = scene_.spec().meshes(static_cast<int>(sample.mesh()));
    if (frames_ > 0 && mesh.motion() == v1::MESH_MOTION_STATIC) continue;
    v1::MeshUpdate& update = *recorded.add_updates();
    update.set_mesh(sample.mesh());
    update.set_positions(sample.positions());
  }
  writer_.add(recorded);
  if (frames_ > 0 && frame.skipped_frames > 0) {
    ++gaps_;
    missed_ += frame.skipped_frames;
  }
  ++frames_;
  return true;
}

std::string LiveRecorder::summary() const {
  std::string out = "recorded " + std::to_string(frames_) + " frames in " + file_ + "\n";
  const auto add = [&](const std::string& line) { out += "a replay differs: " + line + "\n"; };
  if (has_motion(scene_.spec())) add("the first frame stands still");
  if (gaps_ > 0)
    add(std::to_string(missed_) + " frames were missed in " + std::to_string(gaps_) + " gaps" +
        (has_motion(scene_.spec()) ? ", after each of which a step is longer" : ""));
  for (const std::string& line : differences(scene_.spec())) add(line);
  if (was_edited_) add("an edit changed the meshes, and ended the recording");
  return out;
}

}  // namespace collided::cli
