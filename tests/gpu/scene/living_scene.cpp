#include "tests/gpu/scene/living_scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/exclusions.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 3;
constexpr size_t kFewest = 3, kMost = 7;  ///< meshes

Positions rounded(const Positions& positions, Scalar scalar) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, positions);
  return rounded(std::move(c), scalar).end[0];
}

/// A thread, a loose edge from a corner on, and a particle above.
void add_fringe(MeshSpec& sheet, Positions& places) {
  const Vec3d corner = places.front();
  sheet.edges = {{0, sheet.vertex_count}};
  sheet.points = {sheet.vertex_count + 1};
  places.push_back({corner[0] + 0.5, corner[1] + 0.75, corner[2] + 0.25});
  places.push_back({corner[0] + 1.5, corner[1] + 0.5, corner[2] + 0.5});
  sheet.vertex_count += 2;
}

bool brings_elements(const OwnedFrame& frame, uint32_t mesh) {
  return frame.edit && std::any_of(frame.edit->meshes.begin(), frame.edit->meshes.end(), [&](const MeshEdit& edit) {
           return edit.mesh == mesh && count_elements(edit.spec) > 0;
         });
}

}  // namespace

FrameInput OwnedFrame::input() const {
  FrameInput input = frame_of(updates);
  if (edit) input.edit = std::make_shared<const SceneEdit>(*edit);
  return input;
}

LivingScene::LivingScene(Mode mode, Scalar scalar, uint32_t seed) : random_(seed) {
  state_.spec = settings(mode, Accuracy::kExact, scalar, 0.2);
  state_.spec.rest_distance = 0.8;
  for (uint32_t mesh = 0; mesh < 5; ++mesh) add_sheet(state_, mesh);
  state_.spec.meshes[0].motion = MeshMotion::kStatic;
  state_.spec.meshes[1].excludes_rest_pairs = true;
}

uint32_t LivingScene::vertex_count() const {
  uint32_t count = 0;
  for (const MeshSpec& mesh : state_.spec.meshes) count += mesh.vertex_count;
  return count;
}

std::vector<uint32_t> LivingScene::meshes() const {
  std::vector<uint32_t> found;
  for (uint32_t mesh = 0; mesh < state_.spec.meshes.size(); ++mesh)
    if (is_there(mesh)) found.push_back(mesh);
  return found;
}

uint32_t LivingScene::any_mesh() {
  const std::vector<uint32_t> there = meshes();
  return there[random(static_cast<uint32_t>(there.size()))];
}

// A sheet somewhere in a box that has room for about two of them.
void LivingScene::add_sheet(SceneState& state, uint32_t mesh) {
  const double x = random(100) * 0.02, y = random(100) * 0.02, z = random(100) * 0.015;
  MeshSpec sheet{kSide * kSide, grid_triangles(kSide)};
  Positions places = shaken(grid(kSide,
                                 [&](double i, double j) {
                                   return Vec3d{x + i, y + j, z};
                                 }),
                            random(1u << 30), 0.3);
  if (mesh % 2 == 1) add_fringe(sheet, places);
  places = rounded(places, state.spec.scalar);
  state.spec.meshes.resize(std::max<size_t>(state.spec.meshes.size(), mesh + 1));
  state.spec.meshes[mesh] = std::move(sheet);
  for (Case* c : {&state.now, &state.rest}) {
    c->meshes = state.spec.meshes;
    c->start.resize(c->meshes.size());
    c->end.resize(c->meshes.size());
    c->start[mesh] = c->end[mesh] = places;
  }
}

MeshSpec LivingScene::random_rules(MeshSpec mesh) {
  mesh.groups = 1 + random(3);
  mesh.collide_mask = random(3) == 0 ? 1 : ~0u;
  mesh.self_contacts = random(4) != 0;
  mesh.excluded_rings = random(3);
  return mesh;
}

OwnedFrame LivingScene::first_frame() const {
  OwnedFrame frame;
  frame.after = state_;
  for (const uint32_t mesh : meshes())
    frame.updates.push_back({.mesh = mesh, .end = pack(state_.now.end[mesh], state_.spec.scalar)});
  return frame;
}

OwnedFrame LivingScene::next_frame() {
  OwnedFrame frame;
  frame.after = state_;
  move(frame, std::vector<bool>(state_.spec.meshes.size(), false));
  return frame;
}

OwnedFrame LivingScene::next_edit() {
  OwnedFrame frame;
  frame.after = state_;
  frame.edit.emplace();
  std::vector<bool> first(state_.spec.meshes.size() + 1, false);
  const size_t there = meshes().size();
  const uint32_t what = there <= kFewest ? 0 : there >= kMost ? 1 : random(6);
  if (what == 0) add(frame, first);
  if (what == 1) remove(frame);
  if (what == 2) tear(frame, first);
  if (what == 3) drop_triangle(frame);
  if (what == 4) change_rules(frame);
  if (what == 5) change_pairs(frame);
  move(frame, first);
  return frame;
}

// Where one was removed, or as the last one.
void LivingScene::add(OwnedFrame& frame, std::vector<bool>& first) {
  uint32_t mesh = static_cast<uint32_t>(state_.spec.meshes.size());
  for (uint32_t other = 0; other < state_.spec.meshes.size(); ++other)
    if (!is_there(other) && random(2) == 0) mesh = other;
  add_sheet(frame.after, mesh);
  MeshSpec& spec = frame.after.spec.meshes[mesh];
  spec = random_rules(spec);
  spec.motion = random(4) == 0 ? MeshMotion::kStatic : MeshMotion::kDeformable;
  spec.excludes_rest_pairs = random(3) == 0;
  frame.edit->meshes.push_back({mesh, spec});
  first[mesh] = true;
  ++added_;
}

void LivingScene::remove(OwnedFrame& frame) {
  const uint32_t mesh = any_mesh();
  frame.edit->meshes.push_back({mesh, {}});
  frame.after.spec.meshes[mesh] = {};
  for (Case* c : {&frame.after.now, &frame.after.rest}) {
    c->start[mesh].clear();
    c->end[mesh].clear();
  }
  std::erase_if(frame.after.spec.excluded_meshes, [&](const auto& pair) { return pair[0] == mesh || pair[1] == mesh; });
  ++removed_;
}

// A vertex becomes two, which share its triangles.
void LivingScene::tear(OwnedFrame& frame, std::vector<bool>& first) {
  const uint32_t mesh = any_mesh();
  MeshSpec& spec = frame.after.spec.meshes[mesh];
  const uint32_t torn = random(spec.vertex_count), twin = spec.vertex_count++;
  for (auto& triangle : spec.triangles)
    for (uint32_t& vertex : triangle)
      if (vertex == torn && random(2) == 0) vertex = twin;
  frame.edit->meshes.push_back({mesh, spec});
  for (Case* c : {&frame.after.now, &frame.after.rest}) {
    c->start[mesh].push_back(c->start[mesh][torn]);
    c->end[mesh].push_back(c->end[mesh][torn]);
  }
  first[mesh] = true;
  ++tears_;
}

// Its positions stay; what it excludes at rest is found anew.
void LivingScene::drop_triangle(OwnedFrame& frame) {
  const uint32_t mesh = any_mesh();
  MeshSpec& spec = frame.after.spec.meshes[mesh];
  if (spec.triangles.size() < 2) return change_pairs(frame);
  spec.triangles.erase(spec.triangles.begin() + random(static_cast<uint32_t>(spec.triangles.size())));
  frame.edit->meshes.push_back({mesh, spec});
}

void LivingScene::change_rules(OwnedFrame& frame) {
  const uint32_t mesh = any_mesh();
  MeshSpec& spec = frame.after.spec.meshes[mesh];
  spec = random_rules(spec);
  MeshSpec rules = spec;
  rules.triangles.clear(), rules.edges.clear(), rules.points.clear();
  frame.edit->meshes.push_back({mesh, rules});
}

void LivingScene::change_pairs(OwnedFrame& frame) {
  auto& excluded = frame.after.spec.excluded_meshes;
  if (!excluded.empty() && random(2) == 0) {
    frame.edit->included.push_back({excluded.back()[1], excluded.back()[0]});
    excluded.pop_back();
    return;
  }
  const std::array<uint32_t, 2> pair{any_mesh(), any_mesh()};
  const bool is_known = std::any_of(excluded.begin(), excluded.end(), [&](const auto& other) {
    return std::minmax(other[0], other[1]) == std::minmax(pair[0], pair[1]);
  });
  if (is_known) return;
  frame.edit->excluded.push_back(pair);
  excluded.push_back(pair);
}

// A mesh that a frame does not name stands still; one with its first positions in this frame begins where it was torn,
// or where it ends.
void LivingScene::move(OwnedFrame& frame, const std::vector<bool>& first) {
  const Scalar scalar = state_.spec.scalar;
  frame.after.now.meshes = frame.after.rest.meshes = frame.after.spec.meshes;
  for (uint32_t mesh = 0; mesh < frame.after.spec.meshes.size(); ++mesh) {
    const MeshSpec& spec = frame.after.spec.meshes[mesh];
    Positions &start = frame.after.now.start[mesh], &end = frame.after.now.end[mesh];
    start = end;
    if (spec.vertex_count == 0) continue;
    const bool is_static = spec.motion == MeshMotion::kStatic;
    const bool stands = is_static || (!first[mesh] && random(3) == 0);
    if (!stands) end = rounded(shaken(end, random(1u << 30), 0.15), scalar);
    const bool is_new = first[mesh] && (mesh >= state_.spec.meshes.size() || !is_there(mesh));
    if (is_new) start = end;
    const bool has_start = state_.spec.mode == Mode::kCcd && !is_static && !is_new && (first[mesh] || random(2) == 0);
    if (first[mesh] || !stands)
      frame.updates.push_back({.mesh = mesh,
                               .start = has_start ? pack(start, scalar) : std::vector<std::byte>{},
                               .end = pack(end, scalar)});
    const bool may_touch_now = may_touch(frame.after.spec, mesh, mesh) &&
                               (mesh >= state_.spec.meshes.size() || !may_touch(state_.spec, mesh, mesh));
    const bool begins_anew = first[mesh] || may_touch_now || brings_elements(frame, mesh);
    if (begins_anew) frame.after.rest.start[mesh] = frame.after.rest.end[mesh] = end;
  }
}

void LivingScene::try_in_vain(Detector& detector) {
  const auto counts = std::array{added_, removed_, tears_};
  OwnedFrame frame = next_edit();
  added_ = counts[0], removed_ = counts[1], tears_ = counts[2];
  FrameInput input = frame.input();
  SceneEdit edit = *frame.edit;
  int asks = 0;
  const int last = static_cast<int>(random(30));
  switch (random(4)) {
    case 0:
      edit.meshes.push_back({static_cast<uint32_t>(frame.after.spec.meshes.size()) + 1, frame.after.spec.meshes[0]});
      break;
    case 1:
      edit.excluded.push_back({0, 1u << 20});
      break;
    case 2:
      input.updates.push_back({1u << 20, {}, {}});
      break;
    default:
      input.cancelled = [&] { return ++asks > last; };
  }
  input.edit = std::make_shared<const SceneEdit>(edit);
  const bool is_cancelled = static_cast<bool>(input.cancelled);
  try {
    detector.detect(input);
    EXPECT_TRUE(is_cancelled && asks <= last);
    applied(frame);  // it asked less often than that
  } catch (const Cancelled&) {
    EXPECT_TRUE(is_cancelled);
  } catch (const InvalidInput& e) {
    EXPECT_FALSE(is_cancelled) << e.what();
  }
}

}  // namespace collided::test
