// Rigid meshes: the answers of meshes whose vertices are sent, nothing missed of what meets on the way of a screw, and
// the right poses after frames that failed or were trials.

#include <cmath>
#include <random>
#include <tuple>

#include "gpu/base/box.hpp"
#include "gpu/positions/blend.hpp"
#include "gpu/positions/pose.hpp"
#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/positions/screw.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/refusing_quota.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

std::vector<std::byte> bytes_of(const Pose& pose) {
  const auto* bytes = reinterpret_cast<const std::byte*>(pose.rows.data());
  return {bytes, bytes + sizeof(pose.rows)};
}
Pose moved_by(const Vec3d& t) {
  Pose pose;
  for (size_t i = 0; i < 3; ++i) pose.rows[4 * i + 3] = t[i];
  return pose;
}
Pose turned_about_z(double angle, const Vec3d& t = {}) {
  Pose pose = moved_by(t);
  pose.rows[0] = pose.rows[5] = std::cos(angle);
  pose.rows[4] = std::sin(angle);
  pose.rows[1] = -pose.rows[4];
  return pose;
}

template <class Real>
Positions posed(const Positions& rest, const Pose& pose) {
  double rows[12];
  std::copy(pose.rows.begin(), pose.rows.end(), rows);
  Positions out;
  for (const Vec3d& p : rest) {
    const Vec3<Real> at =
        transformed(rows, Vec3<Real>{static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2])});
    out.push_back({double{at.x}, double{at.y}, double{at.z}});
  }
  return out;
}
Positions posed(const Positions& rest, const Pose& pose, Scalar scalar) {
  return scalar == Scalar::kF64 ? posed<double>(rest, pose) : posed<float>(rest, pose);
}

/// A soup that is rigid (or deformable, without contacts of its own), among others.
struct Pair {
  Case c;
  SceneSpec rigid, deformable;

  Pair(Mode mode, Accuracy accuracy, Scalar scalar, double thickness, bool is_loose = false) {
    c = soup(40, 120, 1, 0.2, 0);
    const Case others = soup(41, 120, 1, 0.2, 0);
    add_mesh(c, others.meshes[0].triangles, others.start[0]);
    if (is_loose) c = loosened(c);
    c.meshes[0].self_contacts = false;
    deformable = spec_for(c, settings(mode, accuracy, scalar, thickness));
    rigid = deformable;
    rigid.meshes[0].motion = MeshMotion::kRigid;
    rigid.meshes[0].self_contacts = true;  // which it has none of
  }
};

OwnedUpdate move_of(uint32_t mesh, const Pose& pose) { return {mesh, false, {}, {}, {}, bytes_of(pose)}; }

class Rigid : public OnBackend<::testing::Test> {
 protected:
  /// Both scenes after a first frame, the rigid mesh's at `pose`.
  void begin(const Pair& pair, const Pose& pose) {
    pair_ = &pair;
    rigid_ = Detector::create(pair.rigid), deformable_ = Detector::create(pair.deformable);
    std::vector<OwnedUpdate> first = {whole(0, pair.c.start[0]), whole(1, pair.c.start[1])};
    first[0].transform = bytes_of(pose);
    const FrameResult got = rigid_->detect(frame_of(first));
    first[0] = whole(0, posed(pair.c.start[0], pose, scalar()));
    EXPECT_TRUE(same_contacts(deformable_->detect(frame_of(first)), got));
  }
  OwnedUpdate whole(uint32_t mesh, const Positions& positions) const {
    return {mesh, false, {}, {}, pack(positions, scalar())};
  }
  Scalar scalar() const { return pair_->rigid.scalar; }

  const Pair* pair_ = nullptr;
  std::unique_ptr<Detector> rigid_, deformable_;
};

TEST_F(Rigid, MovedWithoutATurnItAnswersAsIfItsVerticesWereSent) {
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
      for (const Accuracy accuracy :
           {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
        const Pair pair(mode, accuracy, scalar, 0x1p-6, scalar == Scalar::kF64);
        begin(pair, turned_about_z(0.3));
        size_t contacts = 0;
        for (int step = 1; step <= 3; ++step) {
          const Pose pose = turned_about_z(0.3, {0.05 * step, -0.02 * step, 0.1});
          const FrameResult expected = deformable_->detect(frame_of({whole(0, posed(pair.c.start[0], pose, scalar))}));
          EXPECT_TRUE(same_contacts(expected, rigid_->detect(frame_of({move_of(0, pose)}))));
          contacts += expected.vertex_triangle.size() + expected.edge_edge.size();
        }
        EXPECT_GT(contacts, 0u) << "there is nothing to compare";
      }
}

TEST_F(Rigid, InTheFrameItselfATurnIsNoMatter) {
  for (const Accuracy accuracy : {Accuracy::kFast, Accuracy::kCertified, Accuracy::kExact}) {
    const Pair pair(Mode::kDcd, accuracy, Scalar::kF32, 0x1p-5);
    begin(pair, {});
    for (int step = 1; step <= 3; ++step) {
      const Pose pose = turned_about_z(0.7 * step, {0.01, 0, 0});
      const FrameResult expected =
          deformable_->detect(frame_of({whole(0, posed(pair.c.start[0], pose, Scalar::kF32))}));
      EXPECT_TRUE(same_contacts(expected, rigid_->detect(frame_of({move_of(0, pose)}))));
    }
  }
}

TEST_F(Rigid, StaysWhereItIsUntilItIsMovedAgain) {
  const Pair pair(Mode::kCcd, Accuracy::kCertified, Scalar::kF32, 0x1p-6);
  begin(pair, {});
  const Pose pose = moved_by({0.1, 0, 0}), other = moved_by({-0.5, 0.2, 0});
  // A trial, then a frame that is refused: neither moves it.
  const OwnedUpdate elsewhere = move_of(0, other);
  FrameInput trial;
  trial.updates = {elsewhere.view()};
  trial.trial = true;
  rigid_->detect(trial);
  const OwnedUpdate beyond = move_of(0, moved_by({1e38, 0, 0}));
  EXPECT_EQ("updates[0].transform", refused_field([&] { rigid_->detect(frame_of({beyond})); }));
  const OwnedUpdate here = move_of(0, pose);
  const OwnedUpdate same = whole(0, posed(pair.c.start[0], pose, Scalar::kF32));
  EXPECT_TRUE(same_contacts(deformable_->detect(frame_of({same})), rigid_->detect(frame_of({here}))));
  // Left out, it stands still.
  const OwnedUpdate moving = whole(1, pair.c.start[0]);
  EXPECT_TRUE(same_contacts(deformable_->detect(frame_of({moving})), rigid_->detect(frame_of({moving}))));
}

TEST_F(Rigid, BeginsAStepWhereItIsTold) {
  const Pair pair(Mode::kCcd, Accuracy::kCertified, Scalar::kF32, 0);
  begin(pair, {});
  const Pose from = moved_by({0.4, 0, 0}), to = moved_by({0.5, 0.1, 0});
  OwnedUpdate jump = move_of(0, to);
  jump.start_transform = bytes_of(from);
  OwnedUpdate same = whole(0, posed(pair.c.start[0], to, Scalar::kF32));
  same.start = pack(posed(pair.c.start[0], from, Scalar::kF32), Scalar::kF32);
  EXPECT_TRUE(same_contacts(deformable_->detect(frame_of({same})), rigid_->detect(frame_of({jump}))));
}

/// Where the rigid mesh is.
Positions resident(Detector& scene, uint32_t count) {
  std::vector<std::byte> bytes(count * sizeof(Vec3<float>));
  scene.read_positions({0, 1, count}, bytes);
  const auto* at = reinterpret_cast<const Vec3<float>*>(bytes.data());
  Positions out;
  for (uint32_t i = 0; i < count; ++i) out.push_back({double{at[i].x}, double{at[i].y}, double{at[i].z}});
  return out;
}

// However small a part of its way a mesh goes, its pose does not run ahead of its positions.
TEST_F(Rigid, IsWhereItsPoseIsHoweverFarItGoes) {
  const Pair pair(Mode::kCcd, Accuracy::kCertified, Scalar::kF32, 0);
  begin(pair, {});
  const uint32_t count = pair.rigid.meshes[0].vertex_count;
  double at = 0;
  const auto advance = [&](double by) {
    const OwnedUpdate move = move_of(0, moved_by({at + by, 0, 0}));
    FrameInput input;
    input.updates = {move.view()};
    input.advance = true;
    at = blend(at, at + by, *rigid_->detect(input).advanced);
  };
  const auto expect_there = [&] {
    EXPECT_EQ(posed(pair.c.start[0], moved_by({at, 0, 0}), Scalar::kF32), resident(*rigid_, count));
  };
  for (int step = 1; step <= 4; ++step) {
    advance(0.3);
    expect_there();
  }
  // Halfway along what was gone, not along what was wanted.
  const double before = at;
  advance(0.5);
  FrameInput back;
  back.start_fraction = 0.5;
  rigid_->detect(back);
  at = blend(before, at, 0.5);
  expect_there();
}

TEST_F(Rigid, InDiscreteFramesOfBothKindsATurnIsNoMatter) {
  const Pair pair(Mode::kBoth, Accuracy::kCertified, Scalar::kF32, 0x1p-5);
  begin(pair, {});
  const OwnedUpdate turn = move_of(0, turned_about_z(3.1));
  const OwnedUpdate same = whole(0, posed(pair.c.start[0], turned_about_z(3.1), Scalar::kF32));
  FrameInput a, b;
  a.updates = {same.view()}, b.updates = {turn.view()};
  a.mode = b.mode = Mode::kDcd;
  EXPECT_TRUE(same_contacts(deformable_->detect(a), rigid_->detect(b)));
}

TEST_F(Rigid, AFrameThatIsShortOfMemoryAnywhereLeavesASceneThatWorks) {
  const Pair pair(Mode::kCcd, Accuracy::kCertified, Scalar::kF32, 0x1p-6);
  begin(pair, {});
  const OwnedUpdate move = move_of(0, turned_about_z(0.1));
  const std::vector<OwnedUpdate> first = {whole(0, pair.c.start[0]), whole(1, pair.c.start[1])};
  const FrameResult expected = rigid_->detect(frame_of({move}));
  int failed = 0;
  for (int take = 1; failed == take - 1; ++take) {
    const auto quota = std::make_shared<RefusingQuota>();
    SceneSpec spec = pair.rigid;
    spec.memory_quota = quota;
    const auto scene = Detector::create(spec);
    quota->refuse_at(take);
    try {
      scene->detect(frame_of(first));
    } catch (const ResourceExhausted&) {
      ++failed;
      quota->refuse_at(0);
      scene->detect(frame_of(first));
    }
    quota->refuse_at(0);
    EXPECT_TRUE(same_contacts(expected, scene->detect(frame_of({move})))) << "after take " << take;
  }
  EXPECT_GT(failed, 20);
}

TEST_F(Rigid, AFrameBeginsOnNoArc) {
  const Pair pair(Mode::kCcd, Accuracy::kCertified, Scalar::kF32, 0);
  begin(pair, {});
  rigid_->detect(frame_of({move_of(0, turned_about_z(0.1))}));
  FrameInput back;
  back.start_fraction = 0.5;
  EXPECT_EQ("start_fraction", refused_field([&] { rigid_->detect(back); }));
}

/// A contact of features and what is known of it.
using Row = std::tuple<uint32_t, uint32_t, uint8_t, double>;

/// Returns the contacts of mesh 0, or all others.
std::vector<Row> rows_of(const ContactSet& set, bool of_mesh_0, std::array<uint32_t, 2> in_mesh_0) {
  std::vector<Row> rows;
  for (size_t i = 0; i < set.size(); ++i) {
    const auto [first, second] = set.elements[i];
    if ((first < in_mesh_0[0] || second < in_mesh_0[1]) == of_mesh_0)
      rows.emplace_back(first, second, set.flags[i], set.toi[i]);
  }
  return rows;
}

// Pairs that go straight are decided exactly. Pairs with a mesh that turns are what they are at CERTIFIED.
TEST_F(Rigid, ExactFramesDecideWhatGoesStraight) {
  for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
    for (const double thickness : {0.0, 0x1p-4}) {
      SCOPED_TRACE("thickness " + std::to_string(thickness));
      constexpr uint32_t kTriangles = 120;
      Case c = soup(40, kTriangles, 1, 0.2, 0);
      for (const uint32_t seed : {41u, 42u}) {
        Case other = soup(seed, kTriangles, 1, 0.2, 0.1);
        for (Positions* positions : {&other.start[0], &other.end[0]})
          for (Vec3d& p : *positions)  // on a lattice, where many touch
            for (double& x : p) x = std::ldexp(std::round(std::ldexp(x, 4)), -4);
        add_mesh(c, other.meshes[0].triangles, other.start[0], other.end[0]);
      }
      SceneSpec spec = spec_for(c, settings(Mode::kCcd, Accuracy::kExact, scalar, thickness));
      spec.meshes[0].motion = MeshMotion::kRigid;
      const auto answer = [&](Accuracy accuracy, const Pose& pose, Report report) {
        const auto scene = Detector::create(spec);
        std::vector<OwnedUpdate> first, moves = {move_of(0, pose)};
        for (uint32_t mesh = 0; mesh < 3; ++mesh) first.push_back({mesh, false, {}, {}, pack(c.start[mesh], scalar)});
        for (uint32_t mesh = 1; mesh < 3; ++mesh) moves.push_back({mesh, false, {}, {}, pack(c.end[mesh], scalar)});
        scene->detect(frame_of(first));
        FrameInput input = frame_of(moves);
        input.accuracy = accuracy, input.report = report;
        return scene->detect(input);
      };
      const Pose turn = turned_about_z(0.2);
      const FrameResult exact = answer(Accuracy::kExact, turn, Report::kAll),
                        certified = answer(Accuracy::kCertified, turn, Report::kAll),
                        still = answer(Accuracy::kExact, {}, Report::kAll);
      const auto compare = [&](auto set, std::array<uint32_t, 2> in_mesh_0) {
        EXPECT_EQ(rows_of(certified.*set, true, in_mesh_0), rows_of(exact.*set, true, in_mesh_0));
        EXPECT_EQ(rows_of(still.*set, false, in_mesh_0), rows_of(exact.*set, false, in_mesh_0));
        EXPECT_GT(rows_of(exact.*set, true, in_mesh_0).size(), 0u);
        EXPECT_GT(rows_of(exact.*set, false, in_mesh_0).size(), 0u);
      };
      compare(&FrameResult::vertex_triangle, {3 * kTriangles, kTriangles});
      compare(&FrameResult::edge_edge, {3 * kTriangles, 3 * kTriangles});
      EXPECT_GT(exact.counts.exact_decisions, 0u);

      const FrameResult any = answer(Accuracy::kExact, turn, Report::kAnyHit),
                        first = answer(Accuracy::kExact, turn, Report::kEarliestOnly);
      EXPECT_TRUE(any.any_contact);
      EXPECT_EQ(exact.earliest_toi, first.earliest_toi);
      EXPECT_EQ(1u, first.vertex_triangle.size() + first.edge_edge.size());
    }
}

// All contacts of this scene are on arcs.
TEST_F(Rigid, ExactFramesTellOfArcsAlone) {
  const Pair pair(Mode::kCcd, Accuracy::kExact, Scalar::kF64, 0);
  begin(pair, {});
  for (const Report report : {Report::kAll, Report::kAnyHit, Report::kEarliestOnly}) {
    const std::vector<OwnedUpdate> turn = {move_of(0, turned_about_z(0.2))};
    FrameInput input = frame_of(turn);
    input.report = report, input.trial = true;
    const FrameResult exact = rigid_->detect(input);
    input.accuracy = Accuracy::kCertified;
    EXPECT_TRUE(same_contacts(rigid_->detect(input), exact));
    EXPECT_TRUE(exact.any_contact);
  }
}

TEST_F(Rigid, BadMovesAreRefusedByName) {
  const Pair pair(Mode::kCcd, Accuracy::kCertified, Scalar::kF32, 0);
  begin(pair, {});
  const auto field_of = [&](uint32_t mesh, const std::function<void(OwnedUpdate&)>& set) {
    OwnedUpdate update = move_of(mesh, {});
    set(update);
    return refused_field([&] { rigid_->detect(frame_of({update})); });
  };
  const auto with = [&](size_t entry, double value) {
    return field_of(0, [&](OwnedUpdate& update) {
      Pose pose;
      pose.rows[entry] = value;
      update.transform = bytes_of(pose);
    });
  };
  EXPECT_EQ("updates[0].transform", with(0, NAN));
  EXPECT_EQ("updates[0].transform", with(3, INFINITY));
  EXPECT_EQ("updates[0].transform", with(0, 1.001)) << "it stretches";
  EXPECT_EQ("updates[0].transform", with(0, -1)) << "it mirrors";
  EXPECT_EQ("updates[0].transform", with(7, 1e38)) << "it leaves the format's range";
  EXPECT_EQ("updates[0].transform", field_of(0, [](OwnedUpdate& u) { u.transform.pop_back(); }));
  EXPECT_EQ("updates[0].transform", field_of(0, [](OwnedUpdate& u) { u.transform.clear(); }));
  EXPECT_EQ("updates[0].transform", field_of(1, [](OwnedUpdate&) {})) << "of a mesh that is not rigid";
  EXPECT_EQ("updates[0].transform", field_of(0, [](OwnedUpdate& u) { u.transform = bytes_of(turned_about_z(3.1)); }));
  EXPECT_EQ("updates[0].start_transform", field_of(0, [](OwnedUpdate& u) { u.start_transform.resize(8); }));
  EXPECT_EQ("updates[0].end", field_of(0, [&](OwnedUpdate& u) { u.end = whole(0, pair.c.start[0]).end; }));
  EXPECT_EQ("updates[0].indices", field_of(0, [](OwnedUpdate& u) { u.is_sparse = true; }));
  OwnedUpdate late = whole(0, pair.c.start[0]);
  late.start = late.end;
  EXPECT_EQ("updates[0].start", refused_field([&] { rigid_->detect(frame_of({late})); }));
  const auto fresh = Detector::create(pair.rigid);
  const OwnedUpdate move = move_of(0, {}), second = whole(1, pair.c.start[1]);
  EXPECT_EQ("updates[0].end", refused_field([&] { fresh->detect(frame_of({move, second})); }));
}

TEST_F(Rigid, WithoutRigidMeshesNothingIsHeldForThem) {
  const auto parts_of = [](const Detector& scene) {
    uint64_t bytes = 0;
    for (const MemoryPart& part : scene.memory()) bytes += part.part == "rigid" ? part.bytes : 0;
    return bytes;
  };
  const Pair pair(Mode::kDcd, Accuracy::kCertified, Scalar::kF32, 0x1p-6);
  begin(pair, {});
  EXPECT_EQ(0u, parts_of(*deformable_));
  const uint64_t rest = pair.rigid.meshes[0].vertex_count * sizeof(Vec3<float>);
  EXPECT_EQ(rest + sizeof(Box<float>), parts_of(*rigid_)) << "DCD needs no deviations";
}

// The guarantee, against exact arithmetic. See screw.hpp for what is exact.

struct Outcome {
  int met = 0, found = 0, late = 0;
};

/// A triangle that moves along a screw, and one that it meets or not.
Outcome screws(uint32_t seed, int count, Scalar scalar, Accuracy accuracy, bool is_rigid) {
  std::mt19937 random(seed);
  Outcome outcome;
  for (int i = 0; i < count; ++i) {
    const ScrewCase screw(random);
    const std::optional<mpq_class> met = screw.first_sampled_crossing();
    if (!met) continue;
    ++outcome.met;
    Case c;
    add_mesh(c, {{0, 1, 2}}, screw.rest());
    add_mesh(c, {{0, 1, 2}}, screw.obstacle());
    SceneSpec spec = spec_for(c, settings(Mode::kCcd, accuracy, scalar));
    if (is_rigid) spec.meshes[0].motion = MeshMotion::kRigid;
    const auto scene = Detector::create(spec);
    const OwnedUpdate obstacle{1, false, {}, {}, pack(screw.obstacle(), scalar)};
    OwnedUpdate body{0, false, {}, {}, pack(screw.rest(), scalar)};
    if (is_rigid) body.transform = bytes_of(screw.pose(0));
    if (!is_rigid) body.end = pack(posed(screw.rest(), screw.pose(0), scalar), scalar);
    scene->detect(frame_of({body, obstacle}));
    OwnedUpdate next = move_of(0, screw.pose(ScrewCase::kSamples));
    if (!is_rigid)
      next = {0, false, {}, {}, pack(posed(screw.rest(), screw.pose(ScrewCase::kSamples), scalar), scalar)};
    const FrameResult result = scene->detect(frame_of({next}));
    outcome.found += result.any_contact ? 1 : 0;
    outcome.late += result.any_contact && mpq_class(result.earliest_toi) > *met ? 1 : 0;
    for (const uint8_t flags : result.vertex_triangle.flags) EXPECT_EQ(0, flags & kFlagSeparating);
  }
  return outcome;
}

TEST_F(Rigid, NothingThatMeetsOnTheWayOfAScrewIsMissedOrLate) {
  for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
    for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified}) {
      const Outcome outcome = screws(7, 400, scalar, accuracy, true);
      EXPECT_GT(outcome.met, 100);
      EXPECT_EQ(outcome.met, outcome.found);
      EXPECT_EQ(0, outcome.late);
    }
}

TEST_F(Rigid, StraightPathsAloneWouldMissSome) {
  const Outcome outcome = screws(7, 400, Scalar::kF64, Accuracy::kCertified, false);
  EXPECT_LT(outcome.found, outcome.met) << "the cases are too easy to show what the arcs need";
}

}  // namespace
}  // namespace collided::test
