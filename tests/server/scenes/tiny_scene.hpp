#pragma once
// A scene whose contacts are known, in the engine's terms: the lowest corner of a triangle ("tip") falls from z = 1 to
// 1 - depth through the inside of a triangle in z = 0 ("floor"). For depth > 1 there is one contact, vertex 3 with
// triangle 0, at 1 / depth; else there is none.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "server/devices/turns.hpp"
#include "server/frames/frame.hpp"
#include "server/scenes/scene.hpp"
#include "server/scenes/scene_store.hpp"

namespace collided::server {

class CountingObserver : public SceneObserver {
 public:
  void answered(const Scene&, const AnsweredFrame&) override { ++answers; }
  void refused(const Scene&, uint64_t, const std::exception_ptr&) override { ++refusals; }
  void counted(const Scene&, CounterId id, uint64_t times) override {
    counts[static_cast<size_t>(id)] += static_cast<int>(times);
  }
  void expired(const Scene&) override { ++expiries; }
  void device_failed(const Scene&, const std::string&) override { ++failures; }

  int count_of(CounterId id) const { return counts[static_cast<size_t>(id)]; }

  std::atomic<int> answers = 0, refusals = 0, expiries = 0, failures = 0;
  std::array<std::atomic<int>, std::size(kCounters)> counts{};
};

inline Client client(std::string name = "anonymous", ClientLimits limits = {}) {
  return std::make_shared<ClientIdentity>(ClientIdentity{std::move(name), limits});
}

/// `awaited`: triangles of the tip still to be uploaded; 0: it has its one.
inline ScenePlan tip_plan(uint64_t awaited = 0) {
  ScenePlan plan;
  plan.fields = {plan.engine.fields, true};
  plan.meshes = {{"floor", 1, 0}, {"tip", std::max<uint64_t>(1, awaited), awaited}};
  plan.engine.meshes.resize(2);
  for (auto& mesh : plan.engine.meshes) {
    mesh.vertex_count = 3;
    mesh.triangles = {{0, 1, 2}};
  }
  if (awaited > 0) plan.engine.meshes[1].triangles.clear();
  plan.engine.memory_budget = uint64_t{1} << 30;
  plan.engine.threads = 1;
  return plan;
}

using TrianglePositions = std::array<float, 9>;

inline TrianglePositions floor_positions() { return {-2, -2, 0, 2, -2, 0, 0, 2, 0}; }
// The two upper corners stay far above the floor, so that no edge of the tip meets an edge of the floor.
inline TrianglePositions tip_positions(float z) { return {0, 0, z, -0.1f, 0, 9, 0.1f, 0, 9}; }

inline PendingFrame tip_frame(uint64_t id, float depth) {
  struct Memory {
    TrianglePositions floor, start, end;
  };
  const auto memory =
      std::make_shared<const Memory>(Memory{floor_positions(), tip_positions(1), tip_positions(1 - depth)});
  const auto bytes = [](const TrianglePositions& positions) { return std::as_bytes(std::span(positions)); };
  PendingFrame frame;
  frame.frame_id = id;
  frame.input.updates = {{0, {}, bytes(memory->floor), false}, {1, bytes(memory->start), bytes(memory->end), false}};
  frame.meshes = {{0, true}, {1, true}};
  frame.memory = memory;
  return frame;
}

/// Scenes and what they share.
struct SceneBench {
  explicit SceneBench(size_t max_scenes = 64, unsigned concurrent = 2)
      : SceneBench(max_scenes, Turns::Options{.concurrent = concurrent}) {}
  /// All with the clock of the turns.
  SceneBench(size_t max_scenes, const Turns::Options& options)
      : devices({{.turns = options}}), scenes(max_scenes, 16, {devices, observer, "", options.now}) {}
  ~SceneBench() { scenes.clear(); }

  SceneUse add(const Client& owner, SceneRequest request) {
    auto added = scenes.add(owner, std::move(request));
    added.scene->worker().post([scene = added.scene] { scene->engine().build_if_complete(); });
    added.scene->worker().flush();
    return added.scene;
  }
  SceneUse add(const Client& owner = client()) { return add(owner, {tip_plan(), "", 0, 30}); }

  CountingObserver observer;
  ServedDevices devices;
  SceneStore scenes;
};

}  // namespace collided::server
