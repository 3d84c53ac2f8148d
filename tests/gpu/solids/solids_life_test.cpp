// Scenes of solids that move, are edited and refused, against the judge after each frame; rigid solids; what other
// reports and memory of the caller's leave of the same answer.

#include <cmath>
#include <cstring>

#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/solids/judged_solids.hpp"

namespace collided::test {
namespace {

class SolidsLife : public OnBackend<> {};

/// A scene of ten solids in one place, and its life.
class LivingSolids {
 public:
  LivingSolids(uint32_t seed, Accuracy accuracy, Scalar scalar) : random_(seed), accuracy_(accuracy), scalar_(scalar) {
    for (int i = 0; i < 10; ++i) add_solid(scene_, random_body());
    detector_ = Detector::create(spec_of(scene_, looking_into_solids(accuracy, scalar)));
    for (uint32_t m = 0; m < 10; ++m) name(m);
  }

  bool expect(Tally& tally) {
    FrameInput frame = frame_of(updates_);
    if (!edit_.meshes.empty()) frame.edit = std::make_shared<SceneEdit>(edit_);
    const FrameResult result = detector_->detect(frame);
    updates_.clear(), edit_ = {};
    return JudgedScene(scene_).expect(result, accuracy_, tally);
  }
  void move() {
    for (uint32_t m = 0; m < scene_.c.meshes.size(); ++m) {
      if (random_.below(3) == 0 || scene_.c.meshes[m].vertex_count == 0) continue;
      const Body body = moved({{scene_.c.end[m], {}}, scene_.pieces[m]}, lattice_step());
      scene_.c.end[m] = body.surface.positions, scene_.pieces[m] = body.pieces;
      name(m);
    }
  }
  /// Adds a solid, puts another one in a solid's place, or removes one.
  void edit() {
    const auto count = static_cast<uint32_t>(scene_.c.meshes.size());
    const uint32_t m = random_.below(3) == 0 ? count : static_cast<uint32_t>(random_.below(static_cast<int>(count)));
    if (m < count && scene_.c.meshes[m].vertex_count > 0 && random_.below(4) == 0) return remove(m);
    SolidsScene one;
    add_solid(one, random_body());
    if (m == count) scene_.c.meshes.emplace_back(), scene_.c.end.emplace_back(), scene_.pieces.emplace_back();
    scene_.c.meshes[m] = one.c.meshes[0], scene_.c.end[m] = one.c.end[0], scene_.pieces[m] = one.pieces[0];
    edit_.meshes.push_back({m, scene_.c.meshes[m]});
    name(m);
  }
  /// Asks for a solid that is open, inside out or flat; positions of others come with it.
  void expect_refused(int why) {
    Body body = moved(random_.convex(3), {});
    if (why == 0) body.surface.triangles.pop_back();
    if (why == 1) body.surface = reversed(body.surface);
    if (why == 2)
      for (Vec3d& p : body.surface.positions) p[2] = 1;
    SolidsScene one;
    add_solid(one, body);
    FrameInput frame;
    const std::vector<std::byte> bytes = pack(one.c.end[0], scalar_);
    frame.updates.push_back({1, {}, bytes});
    frame.edit = std::make_shared<SceneEdit>(SceneEdit{{{1, one.c.meshes[0]}}});
    EXPECT_TRUE(refused_field([&] { detector_->detect(frame); }).ends_with(".solid")) << why;
  }

 private:
  Vec3d lattice_step() { return {random_.below(3) - 1.0, random_.below(3) - 1.0, random_.below(3) - 1.0}; }
  Body random_body() {
    Body body = random_.any(3);
    return moved(random_.shuffled(body), {0.0 + random_.below(5), 0.0 + random_.below(5), 0.0 + random_.below(5)});
  }
  void remove(uint32_t m) {
    scene_.c.meshes[m] = {}, scene_.c.end[m].clear(), scene_.pieces[m] = {};
    edit_.meshes.push_back({m, {}});
    forget(m);
  }
  void forget(uint32_t m) {
    std::erase_if(updates_, [&](const OwnedUpdate& update) { return update.mesh == m; });
  }
  /// Names the mesh in the next frame.
  void name(uint32_t m) {
    forget(m);
    updates_.push_back({.mesh = m, .end = pack(scene_.c.end[m], scalar_)});
  }

  RandomBodies random_;
  const Accuracy accuracy_;
  const Scalar scalar_;
  SolidsScene scene_;
  std::unique_ptr<Detector> detector_;
  std::vector<OwnedUpdate> updates_;
  SceneEdit edit_;
};

TEST_F(SolidsLife, MovesEditsAndRefusals) {
  Tally tally;
  for (uint32_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    LivingSolids solids(seed, seed % 2 == 0 ? Accuracy::kExact : Accuracy::kFast,
                        seed < 3 ? Scalar::kF32 : Scalar::kF64);
    ASSERT_TRUE(solids.expect(tally));
    for (int frame = 0; frame < 40; ++frame) {
      if (frame % 3 != 0) solids.move();
      if (frame % 3 == 1) solids.edit();
      if (frame % 4 == 2) {
        solids.expect_refused(frame % 3);
      }
      ASSERT_TRUE(solids.expect(tally)) << frame;
    }
  }
  tally.print("edited");
  for (const uint64_t count : {tally.states[0], tally.states[1], tally.apart, tally.inside}) EXPECT_GT(count, 0u);
}

/// Rows of a turn about the axis through 0 and (1, 2, 3), and a step.
std::array<double, 12> pose_of(double angle, const Vec3d& step) {
  const double s = std::sin(angle), c = std::cos(angle), length = std::sqrt(14.0);
  const Vec3d u{1 / length, 2 / length, 3 / length};
  std::array<double, 12> rows{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) {
      const size_t other = 3 - i - k;
      const double turn = i == k ? c : (k == (i + 1) % 3 ? -s : s) * u[other];
      rows[4 * i + k] = turn + (1 - c) * u[i] * u[k];
    }
  for (size_t i = 0; i < 3; ++i) rows[4 * i + 3] = step[i];
  return rows;
}

/// What is judged is where the scene says that its vertices are.
TEST_F(SolidsLife, RigidTurns) {
  Tally tally;
  for (const Scalar scalar : {Scalar::kF64, Scalar::kF32}) {
    RandomBodies random(scalar == Scalar::kF64 ? 1 : 2);
    SolidsScene scene;
    for (int i = 0; i < 12; ++i) add_solid(scene, random.tetrahedron(4));
    for (MeshSpec& mesh : scene.c.meshes) mesh.motion = MeshMotion::kRigid;
    const auto detector = Detector::create(spec_of(scene, looking_into_solids(Accuracy::kExact, scalar)));
    detector->detect(Frame(scene.c, Mode::kDcd, scalar).input());
    for (int frame = 1; frame <= 4; ++frame) {
      std::vector<OwnedUpdate> updates;
      for (uint32_t m = 0; m < 12; ++m) {
        const auto rows = pose_of(0.3 * frame * random.real(), {random.real(), random.real(), random.real()});
        const auto* bytes = reinterpret_cast<const std::byte*>(rows.data());
        updates.push_back({.mesh = m, .transform = {bytes, bytes + sizeof(rows)}});
      }
      const FrameResult result = detector->detect(frame_of(updates));
      std::vector<std::byte> bytes(12 * 4 * position_bytes(scalar));
      detector->read_positions({0, 1, 48}, bytes);
      for (size_t i = 0; i < 12 * 4 * 3; ++i) {
        double x;
        float y;
        std::memcpy(&y, bytes.data() + i * sizeof(float), sizeof(float));
        if (scalar == Scalar::kF64) std::memcpy(&x, bytes.data() + i * sizeof(double), sizeof(double));
        scene.c.end[i / 12][i / 3 % 4][i % 3] = scalar == Scalar::kF64 ? x : y;
      }
      for (size_t m = 0; m < 12; ++m) scene.pieces[m] = {{{scene.c.end[m], scene.c.meshes[m].triangles}}};
      ASSERT_TRUE(JudgedScene(scene).expect(result, Accuracy::kExact, tally)) << frame;
    }
  }
  tally.print("rigid");
  for (const uint64_t count : {tally.states[1], tally.apart, tally.inside}) EXPECT_GT(count, 0u);
}

SolidsScene few(uint32_t seed) {
  RandomBodies random(seed);
  SolidsScene scene;
  for (int i = 0; i < 3; ++i)
    add_solid(scene, moved(random.convex(3), {1.0 * random.below(3), 1.0 * random.below(3), 1.0 * random.below(3)}));
  return scene;
}

TEST_F(SolidsLife, AnyHit) {
  uint32_t hits = 0;
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    const JudgedScene scene(few(seed));
    SceneSpec spec = looking_into_solids(seed % 2 == 0 ? Accuracy::kExact : Accuracy::kFast, Scalar::kF64);
    spec.report = Report::kAnyHit;
    const FrameResult result = run_solids(scene.scene(), spec);
    EXPECT_EQ(result.any_contact, !scene.truth().inside.empty()) << seed;
    EXPECT_EQ(result.vertex_solid.size() + result.pair_states.size(), 0u);
    hits += result.any_contact;
  }
  EXPECT_GT(hits, 10u);
  EXPECT_LT(hits, 95u);
}

/// Vertices in solids come to the host whatever room there is; the rest of the answer is as it is without room.
TEST_F(SolidsLife, WithRoomForContacts) {
  if (kBackend != Backend::kCpu) GTEST_SKIP() << "the room is the host's memory";
  Tally tally;
  for (uint32_t seed = 1; seed <= 20; ++seed)
    for (const Accuracy accuracy : {Accuracy::kFast, Accuracy::kExact})
      for (const uint64_t bytes : {uint64_t{64}, uint64_t{1} << 20}) {
        const JudgedScene scene(few(seed));
        SceneSpec spec = looking_into_solids(accuracy, Scalar::kF64);
        spec.kinds.vertex_triangle = true;
        spec.thickness = 0.25;
        const Frame frame(scene.scene().c, Mode::kDcd, Scalar::kF64);
        FrameResult all = Detector::create(spec_of(scene.scene(), spec))->detect(frame.input());
        FrameInput input = frame.input();
        std::vector<std::byte> memory(bytes + ContactRoom::kAlignment);
        void* begin = memory.data();
        size_t space = memory.size();
        std::align(ContactRoom::kAlignment, bytes, begin, space);
        input.room = {{static_cast<std::byte*>(begin), bytes}, spec.fields, true, 2};
        FrameResult result = Detector::create(spec_of(scene.scene(), spec))->detect(input);
        EXPECT_EQ(result.placed.vertex_solid.count, 0u);
        EXPECT_EQ(result.first.vertex_solid.size(), std::min<size_t>(2, scene.truth().inside.size()));
        EXPECT_EQ(count_contacts(result), count_contacts(all));
        EXPECT_EQ(result.any_contact, all.any_contact);
        for (FrameResult* one : {&all, &result}) one->any_contact = !scene.truth().inside.empty();
        ASSERT_TRUE(scene.expect(result, accuracy, tally) && scene.expect(all, accuracy, tally)) << seed;
      }
  EXPECT_GT(tally.inside, 40u);
}

TEST_F(SolidsLife, WorldsAndShardsRefuseSolids) {
  SceneSpec spec = looking_into_solids(Accuracy::kExact, Scalar::kF64);
  spec.worlds = 2;
  EXPECT_EQ(refused_field([&] { Detector::create(spec_of(few(1), spec)); }), "meshes[0].solid");
  spec.worlds = 0;
  spec.part_devices = {spec.device, spec.device};
  EXPECT_EQ(refused_field([&] { Detector::create(spec_of(few(1), spec)); }), "meshes[0].solid");
}

}  // namespace
}  // namespace collided::test
