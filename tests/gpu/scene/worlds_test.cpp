// Sets of worlds: copies of the same meshes in one step, each of which is answered as a scene of its own.

#include <algorithm>
#include <cstring>
#include <limits>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kWorlds = 7;

/// Two meshes, of which the second stands still.
Case of_one_world() {
  Case c = soup(70, 90, 1, 0.25, 0.1);
  const Case wall = soup(71, 40, 1, 0.3, 0);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  return c;
}

/// The same meshes elsewhere: some worlds lie over each other, two are equal, one is far away and large, one has no
/// contact. `frame`: positions change from one to the next, but for the second mesh.
Case world_of(uint32_t world, int frame) {
  Case c = of_one_world();
  const uint32_t like = world == 4 ? 1 : world;
  const double size = like == 5 ? 1000 : 1, shift = like == 5 ? 1e4 : 0.125 * like;
  const double apart = like == 3 ? 100 : 1;
  const auto place = [&](std::vector<Positions>& meshes, double at) {
    for (size_t mesh = 0; mesh < meshes.size(); ++mesh)
      for (size_t i = 0; i < meshes[mesh].size(); ++i) {
        const double sway = mesh == 0 ? 0.01 * at * static_cast<double>((i * 7 + like * 5) % 11) : 0;
        const double lane = apart > 1 ? apart * static_cast<double>(1000 * mesh + i / 3) : 0;
        Vec3d& p = meshes[mesh][i];
        p = {size * (p[0] + sway) + shift, size * p[1] - shift, size * p[2] + lane};
      }
  };
  place(c.start, frame);
  place(c.end, frame + 1);
  return c;
}

/// One world's frame by itself, or with others as a set's.
class WorldFrame {
 public:
  WorldFrame(uint32_t world, const Case& c, Mode mode, Scalar scalar, bool with_static)
      : world_(world), frame_(c, mode, scalar, with_static) {}
  FrameInput alone() const { return frame_.input(); }
  void add_to(FrameInput& set, uint32_t meshes) const {
    for (MeshPositions update : frame_.input().updates) {
      update.mesh += world_ * meshes;
      set.updates.push_back(update);
    }
  }

 private:
  uint32_t world_;
  Frame frame_;
};

ContactSet slice(const ContactSet& set, uint64_t begin, uint64_t end) {
  ContactSet part = set;
  for_each_field(
      [&](ContactField, auto& column) {
        if (column.empty()) return;
        column.truncate(end);
        column.skip(begin);
      },
      part);
  return part;
}
/// What a set's frame found in one of its worlds.
FrameResult result_of(const FrameResult& all, uint32_t world) {
  FrameResult part;
  for_each_kind(
      [&](ContactKind, const ContactSet& set, const std::vector<uint64_t>& begin, ContactSet& out) {
        EXPECT_EQ(kWorlds + 1, begin.size());
        out = slice(set, begin.at(world), begin.at(world + 1));
      },
      all, all.worlds.begin, part);
  return part;
}
bool same_as_alone(const FrameResult& set, uint32_t world, const FrameResult& alone) {
  const FrameResult part = result_of(set, world);
  return same_bytes(part.vertex_triangle, alone.vertex_triangle) && same_bytes(part.edge_edge, alone.edge_edge) &&
         same_bytes(part.triangle_triangle, alone.triangle_triangle) &&
         same_bytes(part.edge_triangle, alone.edge_triangle);
}

/// A set, and a scene for each of its worlds.
struct Scenes {
  explicit Scenes(SceneSpec spec, const Case& meshes) : mode(spec.mode), scalar(spec.scalar) {
    meshes_of_world = static_cast<uint32_t>(meshes.meshes.size());
    spec.worlds = kWorlds;
    set = Detector::create(spec_for(meshes, spec));
    spec.worlds = 0;
    for (uint32_t world = 0; world < kWorlds; ++world) alone.push_back(Detector::create(spec_for(meshes, spec)));
  }
  WorldFrame frame_of(uint32_t world, int frame) {
    const bool is_first = !std::exchange(has_frame[world], true);
    return {world, world_of(world, frame), mode == Mode::kBoth ? Mode::kDcd : mode, scalar, is_first};
  }
  /// One frame of some worlds; each must be answered as alone. Returns the contacts in all.
  size_t expect_same(const std::vector<uint32_t>& worlds, int frame, const FrameInput& options = {}) {
    std::vector<WorldFrame> frames;
    frames.reserve(worlds.size());
    FrameInput input = options;
    for (const uint32_t world : worlds) frames.push_back(frame_of(world, frame));
    for (const WorldFrame& of_world : frames) of_world.add_to(input, meshes_of_world);
    const FrameResult found = set->detect(input);
    EXPECT_TRUE(found.worlds.refused.empty());
    size_t count = 0;
    for (size_t i = 0; i < worlds.size(); ++i) {
      FrameInput by_itself = frames[i].alone();
      by_itself.mode = options.mode, by_itself.accuracy = options.accuracy;
      const FrameResult expected = alone[worlds[i]]->detect(by_itself);
      EXPECT_TRUE(same_as_alone(found, worlds[i], expected)) << "world " << worlds[i] << ", frame " << frame;
      count += count_contacts(expected);
    }
    EXPECT_EQ(count, count_contacts(found)) << "worlds that the frame does not name have no contacts";
    return count;
  }

  Mode mode;
  Scalar scalar;
  uint32_t meshes_of_world;
  std::unique_ptr<Detector> set;
  std::vector<std::unique_ptr<Detector>> alone;
  bool has_frame[kWorlds] = {};
};

std::vector<uint32_t> all_worlds() {
  std::vector<uint32_t> worlds(kWorlds);
  for (uint32_t world = 0; world < kWorlds; ++world) worlds[world] = world;
  return worlds;
}

using Worlds = OnBackend<>;

constexpr Accuracy kLevels[] = {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified,
                                Accuracy::kExact};

TEST_F(Worlds, EachIsAnsweredAsASceneOfItsOwn) {
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const Accuracy accuracy : kLevels)
      for (const Scalar scalar : {Scalar::kF32, Scalar::kF64}) {
        SCOPED_TRACE(testing::Message() << "mode " << int(mode) << " level " << int(accuracy) << " scalar "
                                        << int(scalar));
        SceneSpec spec = settings(mode, accuracy, scalar, 0x1p-6);
        spec.fields = kEveryField;
        Scenes scenes(spec, of_one_world());
        for (int frame = 0; frame < 2; ++frame) EXPECT_GT(scenes.expect_same(all_worlds(), frame), 100u);
      }
}

TEST_F(Worlds, TrianglePairsAndWhatIsLeftOutAreThoseOfTheWorld) {
  SceneSpec spec = settings(Mode::kDcd, Accuracy::kCertified, Scalar::kF32, 0x1p-6);
  spec.kinds = {.vertex_triangle = true, .edge_edge = true, .triangle_triangle = true, .edge_triangle = true};
  Case meshes = of_one_world();
  meshes.meshes[0].excluded_rings = 2;
  meshes.meshes[1].groups = 2;
  Scenes scenes(spec, meshes);
  EXPECT_GT(scenes.expect_same(all_worlds(), 0), 100u);
  spec.excluded_meshes = {{0, 1}};
  Scenes apart(spec, meshes);
  apart.expect_same(all_worlds(), 0);
}

// Triangles between a few of the vertices have corners in common, and go through each other.
TEST_F(Worlds, NeighboursThatCrossAreThoseOfTheWorld) {
  Case meshes = of_one_world();
  auto& triangles = meshes.meshes[0].triangles;
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const uint32_t first = 7 * t, second = first + 1 + t % 14;
    triangles[t] = {first % 30, second % 30, (second + 14) % 30};
  }
  for (const Accuracy accuracy : kLevels) {
    SceneSpec spec = settings(Mode::kDcd, accuracy, Scalar::kF32);
    spec.kinds = {.triangle_triangle = true};
    Scenes scenes(spec, meshes);
    EXPECT_GT(scenes.expect_same(all_worlds(), 0), 100u);
  }
}

TEST_F(Worlds, LooseElementsAreThoseOfTheWorld) {
  Case meshes = loosened(of_one_world());
  Scenes scenes(settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF64, 0x1p-6), meshes);
  for (int frame = 0; frame < 2; ++frame) scenes.expect_same(all_worlds(), frame);
}

TEST_F(Worlds, MeshesAreAsThickInEach) {
  Case meshes = of_one_world();
  meshes.meshes[0].half_thickness = 0.01;
  meshes.meshes[1].half_thickness = 0.03;
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const Accuracy accuracy : kLevels) {
      Scenes scenes(settings(mode, accuracy, Scalar::kF64, 0x1p-8), meshes);
      for (int frame = 0; frame < 2; ++frame) EXPECT_GT(scenes.expect_same(all_worlds(), frame), 100u);
    }
}

TEST_F(Worlds, AFrameMayBeOfSomeOfThem) {
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    Scenes scenes(settings(mode, Accuracy::kCertified, Scalar::kF32, 0x1p-6), of_one_world());
    scenes.expect_same({1, 4}, 0);
    scenes.expect_same({5}, 1);
    scenes.expect_same({4, 0, 3}, 2);
    scenes.expect_same(all_worlds(), 3);
    scenes.expect_same({6}, 4);
  }
}

TEST_F(Worlds, FramesMayAskForTheOtherModeAndAnotherLevel) {
  SceneSpec spec = settings(Mode::kBoth, Accuracy::kCertified, Scalar::kF64, 0x1p-5);
  spec.min_separation = 0x1p-8;
  Scenes scenes(spec, of_one_world());
  FrameInput near, way;
  near.mode = Mode::kDcd, way.mode = Mode::kCcd;
  way.accuracy = Accuracy::kGuarded;
  scenes.expect_same(all_worlds(), 0, near);
  scenes.expect_same({0, 2, 6}, 1, way);
  scenes.expect_same(all_worlds(), 2, way);
}

/// A frame of the whole set with one coordinate of a world's first mesh replaced.
struct Spoilt {
  explicit Spoilt(Scenes& scenes, int frame, uint32_t world, double value) {
    for (uint32_t w = 0; w < kWorlds; ++w) {
      const bool is_first = !std::exchange(scenes.has_frame[w], true);
      frames.emplace_back(w, world_of(w, frame), scenes.mode, scenes.scalar, is_first);
    }
    for (const WorldFrame& of_world : frames) of_world.add_to(input, scenes.meshes_of_world);
    for (MeshPositions& update : input.updates) {
      if (update.mesh != world * scenes.meshes_of_world) continue;
      bytes.assign(update.end.begin(), update.end.end());
      const auto bad = static_cast<float>(value);
      std::memcpy(&bytes[5 * sizeof(float)], &bad, sizeof(bad));
      update.end = bytes;
    }
  }
  std::vector<WorldFrame> frames;
  std::vector<std::byte> bytes;
  FrameInput input;
};

TEST_F(Worlds, ABadOneHarmsNoOther) {
  constexpr uint32_t kBad = 2;
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const bool is_first : {true, false}) {
      Scenes scenes(settings(mode, Accuracy::kCertified, Scalar::kF32, 0x1p-6), of_one_world());
      if (!is_first) scenes.expect_same(all_worlds(), 0);
      const Spoilt spoilt(scenes, 1, kBad, std::numeric_limits<double>::quiet_NaN());
      const FrameResult found = scenes.set->detect(spoilt.input);
      ASSERT_EQ(1u, found.worlds.refused.size());
      const RefusedWorld& refused = found.worlds.refused[0];
      EXPECT_EQ(kBad, refused.world);
      EXPECT_TRUE(refused.field.ends_with(".end")) << refused.field;
      EXPECT_NE(std::string::npos, refused.what.find("world 2, mesh 0, vertex 1, coordinate z is nan")) << refused.what;
      for (uint32_t world = 0; world < kWorlds; ++world)
        if (world == kBad)
          EXPECT_EQ(0u, count_contacts(result_of(found, world)));
        else
          EXPECT_TRUE(same_as_alone(found, world, scenes.alone[world]->detect(spoilt.frames[world].alone())));
      scenes.has_frame[kBad] = !is_first;
      scenes.expect_same(all_worlds(), 2);  // of the refused world from where it was
    }
}

TEST_F(Worlds, AllMayBeBad) {
  Scenes scenes(settings(Mode::kDcd, Accuracy::kCertified, Scalar::kF32, 0x1p-6), of_one_world());
  FrameInput input;
  Case c = of_one_world();
  c.end[0][3][0] = std::numeric_limits<double>::infinity();
  const WorldFrame bad(3, c, Mode::kDcd, Scalar::kF32, true);
  bad.add_to(input, 2);
  const FrameResult found = scenes.set->detect(input);
  ASSERT_EQ(1u, found.worlds.refused.size());
  EXPECT_EQ(0u, count_contacts(found));
  scenes.expect_same(all_worlds(), 0);
}

// Refusing many worlds takes long, and no stage follows that would ask.
TEST_F(Worlds, AFrameOfBadOnesCanBeCancelled) {
  constexpr uint32_t kMany = 1 << 15;
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kFast, Scalar::kF32);
  spec.worlds = kMany;
  spec.meshes.resize(1);
  spec.meshes[0].vertex_count = 3;
  spec.meshes[0].triangles = {{0, 1, 2}};
  const auto set = Detector::create(spec);
  const std::vector<float> nothing(9, std::numeric_limits<float>::quiet_NaN());
  FrameInput input;
  for (uint32_t world = 0; world < kMany; ++world) {
    MeshPositions& update = input.updates.emplace_back();
    update.mesh = world;
    update.end = std::as_bytes(std::span(nothing));
  }
  int asked = 0;
  input.cancelled = [&] { return ++asked > 3; };
  EXPECT_THROW(set->detect(input), Cancelled);
  input.cancelled = {};
  EXPECT_EQ(set->detect(input).worlds.refused.size(), kMany);
}

TEST_F(Worlds, TurnsAreRefusedByWorld) {
  Scenes scenes(settings(Mode::kDcd, Accuracy::kFast, Scalar::kF32, 0x1p-6), of_one_world());
  scenes.expect_same({0, 1}, 0);
  scenes.has_frame[1] = scenes.has_frame[2] = false;
  std::vector<WorldFrame> frames;
  FrameInput input;
  for (const uint32_t world : {0u, 1u}) frames.push_back(scenes.frame_of(world, 1));  // 1 with its static mesh again
  frames.emplace_back(2, world_of(2, 1), Mode::kDcd, Scalar::kF32, false);            // 2 without, for the first time
  for (const WorldFrame& of_world : frames) of_world.add_to(input, 2);
  const FrameResult found = scenes.set->detect(input);
  ASSERT_EQ(2u, found.worlds.refused.size());
  EXPECT_EQ(1u, found.worlds.refused[0].world);
  EXPECT_NE(std::string::npos, found.worlds.refused[0].what.find("static")) << found.worlds.refused[0].what;
  EXPECT_EQ(2u, found.worlds.refused[1].world);
  EXPECT_EQ("updates", found.worlds.refused[1].field);
  EXPECT_TRUE(same_as_alone(found, 0, scenes.alone[0]->detect(frames[0].alone())));
}

TEST_F(Worlds, OneOfOneTriangleIsASetToo) {
  Case one;
  add_mesh(one, {{{0, 1, 2}}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  SceneSpec spec = settings(Mode::kDcd, Accuracy::kCertified, Scalar::kF64, 0.5);
  for (const uint32_t worlds : {1u, 3u}) {
    spec.worlds = worlds;
    const auto set = Detector::create(spec_for(one, spec));
    const std::vector<std::byte> bytes = pack(one.end[0], Scalar::kF64);
    FrameInput input;
    for (uint32_t world = 0; world < worlds; ++world) input.updates.push_back({.mesh = world, .end = bytes});
    const FrameResult found = set->detect(input);
    EXPECT_EQ(0u, count_contacts(found)) << "worlds in one place do not touch";
    EXPECT_EQ(worlds + 1, found.worlds.begin.edge_edge.size());
    EXPECT_EQ(Engine::kLbvh, found.broad_phase.engine);
  }
}

TEST_F(Worlds, WhatIsOfTheWholeSceneIsRefused) {
  const Case meshes = of_one_world();
  const auto refused_of = [&](auto change) {
    SceneSpec spec = spec_for(meshes, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32));
    spec.worlds = 3;
    change(spec);
    return refused_field([&] { Detector::create(spec); });
  };
  EXPECT_EQ("worlds", refused_of([](SceneSpec& spec) { spec.worlds = kMaxWorlds + 1; }));
  EXPECT_EQ("engine", refused_of([](SceneSpec& spec) { spec.engine = Engine::kOctree; }));
  EXPECT_EQ("report", refused_of([](SceneSpec& spec) { spec.report = Report::kAnyHit; }));
  EXPECT_EQ("meshes[0].motion", refused_of([](SceneSpec& spec) { spec.meshes[0].motion = MeshMotion::kRigid; }));
  EXPECT_EQ("meshes[1].excludes_rest_pairs",
            refused_of([](SceneSpec& spec) { spec.meshes[1].excludes_rest_pairs = true; }));
  Scenes scenes(settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32), meshes);
  scenes.expect_same(all_worlds(), 0);
  const auto refused_frame = [&](auto change) {
    FrameInput input;
    change(input);
    return refused_field([&] { scenes.set->detect(input); });
  };
  EXPECT_EQ("advance", refused_frame([](FrameInput& input) { input.advance = true; }));
  EXPECT_EQ("trial", refused_frame([](FrameInput& input) { input.trial = true; }));
  EXPECT_EQ("start_fraction", refused_frame([](FrameInput& input) { input.start_fraction = 0.5; }));
  EXPECT_EQ("report", refused_frame([](FrameInput& input) { input.report = Report::kEarliestOnly; }));
  EXPECT_EQ("edit", refused_frame([](FrameInput& input) { input.edit = std::make_shared<SceneEdit>(); }));
  EXPECT_EQ("updates[0].mesh",
            refused_frame([](FrameInput& input) { input.updates.push_back({.mesh = 2 * kWorlds}); }));
  scenes.expect_same(all_worlds(), 1);
}

TEST_F(Worlds, TrianglesAreHeldOnce) {
  const Case meshes = of_one_world();
  const auto bytes_of = [&](uint32_t worlds, const char* part) {
    SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32);
    spec.worlds = worlds;
    uint64_t bytes = 0;
    for (const MemoryPart& held : Detector::create(spec_for(meshes, spec))->memory())
      if (held.part == part) bytes += held.bytes;
    return bytes;
  };
  EXPECT_EQ(bytes_of(0, "triangles"), bytes_of(50, "triangles"));
  EXPECT_EQ(bytes_of(0, "edges"), bytes_of(50, "edges"));
  EXPECT_EQ(50 * bytes_of(0, "boxes"), bytes_of(50, "boxes"));
}

}  // namespace
}  // namespace collided::test
