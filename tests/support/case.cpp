#include "tests/support/case.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace collided::test {
namespace {

template <class T>
std::vector<std::byte> pack_as(const Positions& positions) {
  std::vector<std::byte> bytes(positions.size() * 3 * sizeof(T));
  size_t at = 0;
  for (const Vec3d& p : positions) {
    for (double x : p) {
      const T value = static_cast<T>(x);
      std::memcpy(bytes.data() + at, &value, sizeof(T));
      at += sizeof(T);
    }
  }
  return bytes;
}

// Volatile: GCC 12 at -O3 vectorises the rounding in place and skips some of the last coordinates.
double through_float(double x) {
  volatile float narrow = static_cast<float>(x);
  return static_cast<double>(narrow);
}

void round_to_float(std::vector<Positions>& all) {
  for (Positions& positions : all)
    for (Vec3d& p : positions)
      for (double& x : p) x = through_float(x);
}

std::vector<Positions> split(const std::vector<scenes::Mesh>& meshes, const Positions& all) {
  std::vector<Positions> parts;
  auto from = all.begin();
  for (const scenes::Mesh& mesh : meshes) {
    parts.emplace_back(from, from + mesh.vertex_count);
    from += mesh.vertex_count;
  }
  return parts;
}

}  // namespace

std::vector<std::byte> pack(const Positions& positions, Scalar scalar) {
  return scalar == Scalar::kF32 ? pack_as<float>(positions) : pack_as<double>(positions);
}

std::vector<std::byte> encoded(const Positions& positions, const PositionBox& box) {
  std::vector<std::byte> out(positions.size() * 3 * sizeof(uint16_t));
  size_t at = 0;
  for (const Vec3d& p : positions)
    for (size_t k = 0; k < 3; ++k) {
      const double step = (box.upper[k] - box.lower[k]) / 65535;
      const auto q = static_cast<uint16_t>(std::clamp(std::round((p[k] - box.lower[k]) / step), 0.0, 65535.0));
      std::memcpy(out.data() + at, &q, sizeof(q));
      at += sizeof(q);
    }
  return out;
}

Frame::Frame(const Case& c, Mode mode, Scalar scalar, bool with_static) {
  for (uint32_t m = 0; m < c.meshes.size(); ++m) {
    const bool is_static = c.meshes[m].motion == MeshMotion::kStatic;
    if (is_static && !with_static) continue;
    Update update{m, {}, pack(c.end[m], scalar)};
    if (mode == Mode::kCcd && !is_static) update.start = pack(c.start[m], scalar);
    updates_.push_back(std::move(update));
  }
}

FrameInput Frame::input() const {
  FrameInput input;
  for (const Update& u : updates_) input.updates.push_back({u.mesh, u.start, u.end});
  return input;
}

Case rounded(Case c, Scalar scalar) {
  if (scalar == Scalar::kF32) {
    round_to_float(c.start);
    round_to_float(c.end);
  }
  return c;
}

Case case_of(const scenes::Scene& scene, double t0, double t1) {
  Case c;
  for (const scenes::Mesh& mesh : scene.meshes()) {
    MeshSpec spec;
    spec.vertex_count = mesh.vertex_count;
    spec.triangles = mesh.triangles;
    if (mesh.is_static) spec.motion = MeshMotion::kStatic;
    c.meshes.push_back(std::move(spec));
  }
  c.start = split(scene.meshes(), scene.positions(t0));
  c.end = split(scene.meshes(), scene.positions(t1));
  return c;
}

Case case_of(const std::string& scene, double t, Mode mode) {
  const double t0 = mode == Mode::kCcd ? std::max(0.0, t - 1.0 / 60) : t;
  Case c = case_of(*scenes::make_scene(scene), t0, t);
  c.name = scene;
  return c;
}

bool is_procedural(const std::string& name) {
  const auto is_it = [&](const scenes::SceneInfo& info) { return info.name == name; };
  return std::ranges::any_of(scenes::list_scenes(), is_it) || std::ranges::any_of(scenes::list_variants(), is_it);
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const scenes::SceneInfo& info : scenes::list_scenes()) names.push_back(info.name);
  return names;
}

void add_mesh(Case& c, std::vector<std::array<uint32_t, 3>> triangles, Positions start, Positions end, bool is_static) {
  MeshSpec spec;
  spec.vertex_count = static_cast<uint32_t>(start.size());
  spec.triangles = std::move(triangles);
  if (is_static) spec.motion = MeshMotion::kStatic;
  c.meshes.push_back(std::move(spec));
  c.end.push_back(end.empty() ? start : std::move(end));
  c.start.push_back(std::move(start));
}

SceneSpec spec_for(const Case& c, SceneSpec settings) {
  settings.meshes = c.meshes;
  return settings;
}

FrameResult run_case(const Case& c, const SceneSpec& settings) {
  const Frame frame(c, settings.mode, settings.scalar);
  return Detector::create(spec_for(c, settings))->detect(frame.input());
}

}  // namespace collided::test
