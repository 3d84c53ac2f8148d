// Tests rigid meshes that turn and advance. They end on their screws, at the fraction that the answer tells. On the
// screw from start to end they keep their floors. Screws in 67 digits and distances at many times judge that.

#include <cmath>
#include <cstdio>

#include "gpu/positions/rigid_arc.hpp"
#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/exact_screw.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/shards/one_and_shards.hpp"
#include "tests/support/distance.hpp"
#include "tests/support/families/query_families_shapes.hpp"

namespace collided::test {
namespace {

std::vector<std::byte> bytes_of(const Pose& pose) {
  const auto* bytes = reinterpret_cast<const std::byte*>(pose.rows.data());
  return {bytes, bytes + sizeof(pose.rows)};
}

/// A turn about `axis` through `centre`, and a slide along it.
ExactScrew screw_about(const Vec3d& axis, const Vec3d& centre, double angle, double slide = 0) {
  ExactScrew screw;
  screw.axis = unit(exact(axis)), screw.centre = exact(centre);
  screw.angle = exact(angle), screw.slide = exact(slide);
  return screw;
}

/// The part of a screw that an advance goes: beside the point at `fraction` of each vertex's chord.
ExactScrew part_of(const ExactScrew& whole, double fraction) {
  ExactScrew part = whole;
  const double half = whole.angle.get_d() / 2;
  part.angle = exact(half + std::asin((2 * fraction - 1) * std::sin(half)));
  part.slide = exact(fraction) * whole.slide;
  return part;
}

using Tetrahedron = std::array<Vec3d, 4>;
constexpr std::array<std::array<uint32_t, 3>, 4> kFaces = {{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
constexpr std::array<std::array<size_t, 2>, 6> kEdges = {{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Returns the distance of the surfaces.
double distance(const Tetrahedron& a, const Tetrahedron& b) {
  double least = HUGE_VAL;
  for (const auto& [i, j, k] : kFaces)
    for (size_t v = 0; v < 4; ++v)
      least = std::min({least, point_triangle(a[v], {b[i], b[j], b[k]}).distance,
                        point_triangle(b[v], {a[i], a[j], a[k]}).distance});
  for (const auto& [i, j] : kEdges)
    for (const auto& [k, l] : kEdges) least = std::min(least, edge_edge({a[i], a[j]}, {b[k], b[l]}).distance);
  return least;
}

double length_of(const Vec3d& v) { return std::hypot(v[0], v[1], v[2]); }
Positions positions_of(const Tetrahedron& body) { return {body.begin(), body.end()}; }

/// Tetrahedra, and where they are.
class Bodies {
 public:
  struct Body {
    Tetrahedron rest;
    MeshMotion motion = MeshMotion::kRigid;
    Pose pose = {};
  };
  /// Holds where a body is to go: the pose of a rigid one, or the vertices of a deformable one.
  struct Target {
    Pose pose = {};
    Tetrahedron at = {};
  };

  Bodies(std::vector<Body> bodies, double min_separation, const SceneSpec& how)
      : bodies_(std::move(bodies)), scalar_(how.scalar) {
    Case c;
    for (const Body& body : bodies_)
      add_mesh(c, {kFaces.begin(), kFaces.end()}, positions_of(body.rest), {}, body.motion == MeshMotion::kStatic);
    SceneSpec spec = spec_for(c, how);
    spec.min_separation = min_separation;
    for (size_t i = 0; i < bodies_.size(); ++i) spec.meshes[i].motion = bodies_[i].motion;
    scene_ = Detector::create(spec);
    std::vector<OwnedUpdate> first;
    for (uint32_t i = 0; i < bodies_.size(); ++i)
      first.push_back({i, false, {}, {}, pack(positions_of(bodies_[i].rest), scalar_)});
    scene_->detect(frame_of(first));
  }

  /// Returns how far each rigid body went.
  std::vector<double> advance(const std::vector<Target>& targets, AdvanceMode mode) {
    std::vector<OwnedUpdate> moves;
    for (uint32_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i].motion == MeshMotion::kRigid) moves.push_back({i, false, {}, {}, {}, bytes_of(targets[i].pose)});
      if (bodies_[i].motion == MeshMotion::kDeformable)
        moves.push_back({i, false, {}, {}, pack(positions_of(targets[i].at), scalar_)});
    }
    FrameInput input = frame_of(moves);
    input.advance = input.limits = true, input.advance_mode = mode;
    result_ = scene_->detect(input);
    std::vector<double> gone(bodies_.size(), mode == AdvanceMode::kAllOrOne ? *result_.advanced : 1.0);
    for (size_t i = 0; i < result_.shortened.ids.size(); ++i) {
      const uint32_t id = result_.shortened.ids[i], body = mode == AdvanceMode::kPerMesh ? id : id / 4;
      gone[body] = std::min(gone[body], result_.shortened.fractions[i]);
    }
    for (size_t i = 0; i < bodies_.size(); ++i) bodies_[i].pose = pose_along(bodies_[i].pose, targets[i].pose, gone[i]);
    return gone;
  }
  const FrameResult& result() const { return result_; }
  const Topology& topology() const { return scene_->topology(); }

  /// Returns where the engine has a body.
  Tetrahedron resident(uint32_t body) const {
    std::vector<std::byte> bytes(4 * position_bytes(scalar_));
    scene_->read_positions({4 * body, 1, 4}, bytes);
    Tetrahedron out;
    for (size_t v = 0; v < 4; ++v)
      for (size_t k = 0; k < 3; ++k) {
        const std::byte* from = bytes.data() + (3 * v + k) * (scalar_ == Scalar::kF64 ? 8 : 4);
        if (scalar_ == Scalar::kF64) std::memcpy(&out[v][k], from, 8);
        float narrow = 0;
        if (scalar_ != Scalar::kF64) std::memcpy(&narrow, from, 4), out[v][k] = double{narrow};
      }
    return out;
  }
  const Body& operator[](size_t i) const { return bodies_[i]; }
  size_t size() const { return bodies_.size(); }

 private:
  std::vector<Body> bodies_;
  const Scalar scalar_;
  std::unique_ptr<Detector> scene_;
  FrameResult result_;
};

/// Returns where a pose puts a point.
Vec3d posed(const Pose& pose, const Vec3d& p) { return posed_by<double>(pose, p); }
Pose moved(const Pose& pose, const ExactScrew& by) {
  const ExactScrew::Moment end = by.at(1);
  Pose out;
  for (size_t k = 0; k < 4; ++k) {
    const Vec3d column = {pose.rows[k], pose.rows[4 + k], pose.rows[8 + k]};
    const ExactVec origin = end(exact(Vec3d{0, 0, 0}));
    const Vec3d to = k == 3 ? nearest(end(exact(column))) : nearest(end(exact(column)) - origin);
    for (size_t i = 0; i < 3; ++i) out.rows[4 * i + k] = to[i];
  }
  return out;
}
Tetrahedron posed(const Pose& pose, const Tetrahedron& rest) {
  Tetrahedron out;
  for (size_t v = 0; v < 4; ++v) out[v] = posed(pose, rest[v]);
  return out;
}

Tetrahedron bar(const Vec3d& at, double length) {
  return {Vec3d{at[0], at[1], at[2]},
          {at[0] + 1e-2, at[1], at[2]},
          {at[0], at[1] + 1e-2, at[2]},
          {at[0], at[1], at[2] + length}};
}

class TurningAdvances : public OnBackend<::testing::Test> {};

// However near they are and far from the axis: seen from one of them, the others stand still.
TEST_F(TurningAdvances, WhatTurnsTogetherGoesAllTheWay) {
  for (const Scalar scalar : {Scalar::kF64, Scalar::kF32})
    for (const AdvanceMode mode : {AdvanceMode::kAllOrOne, AdvanceMode::kPerMesh})
      for (const double angle : {1e-9, 1e-3, 0.1, 0.9}) {
        SCOPED_TRACE("angle " + std::to_string(angle));
        const double gap = 1e-3, at = 0.5;
        Bodies bodies({{bar({at, 0, 0}, 1)}, {bar({at, 1e-2 + gap, 0.1}, 1)}, {bar({at + 1e-2 + gap, 0, 0}, 1)}}, 1e-3,
                      settings(Mode::kCcd, Accuracy::kCertified, scalar));
        for (int step = 0; step < 5; ++step) {
          const ExactScrew screw = screw_about({0, 0, 1}, {0, 0, 0}, angle, 0.01);
          std::vector<Bodies::Target> targets;
          for (size_t i = 0; i < bodies.size(); ++i) targets.push_back({moved(bodies[i].pose, screw)});
          for (const double gone : bodies.advance(targets, mode)) EXPECT_EQ(1, gone);
          EXPECT_EQ(1, bodies.result().advanced);
        }
      }
}

// A box that rests at the minimum separation of a floor rolls on over its edge. Turns that bend too much to tell are
// gone in parts.
TEST_F(TurningAdvances, WhatRollsOnAFloorGetsThere) {
  const double m = 1e-3;
  const Tetrahedron floor = {Vec3d{-20, -20, 0}, {20, -20, 0}, {0, 20, 0}, {0, 0, -20}};
  for (const double angle : {0.01, 0.1}) {
    Bodies bodies({{floor, MeshMotion::kStatic}, {{Vec3d{0, 0, m}, {1, 0, m}, {0, 1, m}, {0.3, 0.3, 1 + m}}}}, m,
                  settings(Mode::kCcd, Accuracy::kCertified));
    Pose target = bodies[1].pose;
    int frames = 0;
    for (int step = 0; step < 10; ++step) {
      target = moved(target, screw_about({0, 1, 0}, posed(target, Vec3d{1, 0, m}), angle));
      for (double gone = 0; gone < 1; ++frames) {
        gone = bodies.advance({{}, {target}}, AdvanceMode::kPerMesh)[1];
        ASSERT_GT(gone, 0);
        ASSERT_LT(frames, 200);
      }
    }
    std::printf("turns of %g rad on a floor: %.1f frames each\n", angle, frames / 10.0);
    EXPECT_LE(frames, angle < 0.05 ? 10 : 40);
  }
}

// A body that spins fast and flies at a wall gets near it.
TEST_F(TurningAdvances, WhatSpinsGetsNearAWall) {
  const double m = 1e-3;
  const Tetrahedron wall = {Vec3d{5, -20, -20}, {5, 20, -20}, {5, 0, 20}, {20, 0, 0}};
  Bodies bodies(
      {{wall, MeshMotion::kStatic}, {{Vec3d{-0.5, -0.5, -0.5}, {0.5, -0.5, 0.5}, {0.5, 0.5, -0.5}, {-0.5, 0.5, 0.5}}}},
      m, settings(Mode::kCcd, Accuracy::kCertified));
  double apart = 4;
  for (int step = 0; step < 40; ++step) {
    Pose target = moved(bodies[1].pose, screw_about({0.2, 0.1, 1}, posed(bodies[1].pose, Vec3d{0, 0, 0}), 2));
    target.rows[3] += 0.5;
    bodies.advance({{}, {target}}, AdvanceMode::kPerMesh);
    apart = distance(bodies.resident(0), bodies.resident(1));
    ASSERT_GE(apart, m * (1 - 1e-9));
  }
  std::printf("%g from the wall\n", apart);
  EXPECT_LT(apart, 0.1);
}

/// Counts what was judged, and adds up how far rigid bodies went.
struct Judged {
  int steps = 0, ways = 0, rigid = 0, shortened = 0, limits = 0, later_limits = 0;
  double share = 0;
};

/// Bodies within reach of each other, which screws drive through each other; judged at many times of each step.
class Crowd {
 public:
  Crowd(uint32_t seed, const SceneSpec& how)
      : random_(seed),
        min_separation_(std::pow(10, random_.within(-3, -1.5))),
        offset_(random_.integer(0, 2) == 0 ? 100 : 0),
        unit_(how.scalar == Scalar::kF64 ? 0x1p-53 : 0x1p-24),
        mode_(static_cast<AdvanceMode>(random_.integer(0, 2))),
        turn_together_(random_.integer(0, 2) == 0),
        bodies_(any_bodies(), min_separation_, how) {}

  void step(Judged& judged) {
    aim();
    gone_ = bodies_.advance(targets_, mode_);
    find_ends(judged);
    constexpr int kTimes = 24;
    for (int time = 0; time <= kTimes; ++time) judge(1.0 * time / kTimes, judged);
    judge_limits(judged);
    ++judged.steps;
  }

 private:
  static constexpr size_t kCount = 6;
  static MeshMotion motion_of(size_t body) {
    return body < 4 ? MeshMotion::kRigid : body == 4 ? MeshMotion::kDeformable : MeshMotion::kStatic;
  }
  bool is_rigid(size_t body) const { return motion_of(body) == MeshMotion::kRigid; }
  double size() const { return offset_ + 30; }

  std::vector<Bodies::Body> any_bodies() {
    std::vector<Bodies::Body> made;
    while (made.size() < kCount) {
      Bodies::Body body{{}, motion_of(made.size())};
      const Vec3d at = plus(random_.vector(1), {offset_, offset_, 0});
      for (Vec3d& v : body.rest) {
        v = plus(at, random_.vector(0.5));
        for (double& x : v) x = std::ldexp(std::round(std::ldexp(x, 12)), -12);
      }
      const auto is_near = [&](const auto& other) { return distance(other.rest, body.rest) < 0.2 * min_separation_; };
      const auto edge = [&](size_t i) { return exact(minus(body.rest[i], body.rest[0])); };
      const bool is_flat = abs(dot(cross(edge(1), edge(2)), edge(3))) < 0.01;
      if (!is_flat && std::none_of(made.begin(), made.end(), is_near)) made.push_back(body);
    }
    return made;
  }

  ExactScrew any_screw(const Vec3d& near) {
    const double angle = random_.chance(0.5) ? random_.within(0, 2.5) : std::pow(10, random_.within(-9, 0));
    const Vec3d centre = plus(near, random_.vector(random_.chance(0.25) ? 10 : 0.5));
    return screw_about(random_.vector(1), centre, angle, random_.within(-1, 1));
  }
  /// Chooses where all are to go.
  void aim() {
    least_ = min_separation_;
    start_.clear(), screws_.clear(), targets_.clear();
    for (uint32_t i = 0; i < kCount; ++i) {
      const Tetrahedron at = bodies_.resident(i);
      for (const Tetrahedron& other : start_) least_ = std::min(least_, distance(other, at));
      start_.push_back(at);
      screws_.push_back(turn_together_ && i > 0 ? screws_[0] : any_screw(at[0]));
      Bodies::Target target{moved(bodies_[i].pose, screws_[i]), at};
      for (Vec3d& p : target.at) p = plus(p, random_.vector(0.5));
      targets_.push_back(target);
    }
    before_.clear();
    for (uint32_t i = 0; i < kCount; ++i) before_.push_back(posed(bodies_[i].pose, bodies_[i].rest));
  }

  /// Rigid bodies are where their screws take them.
  void find_ends(Judged& judged) {
    parts_.clear(), end_.clear();
    for (uint32_t i = 0; i < kCount; ++i) {
      parts_.push_back(part_of(screws_[i], gone_[i]));
      end_.push_back(bodies_.resident(i));
      if (!is_rigid(i)) continue;
      ++judged.rigid, judged.share += gone_[i], judged.shortened += gone_[i] < 1;
      const ExactScrew::Moment end = parts_.back().at(1);
      for (size_t v = 0; v < 4; ++v)
        ASSERT_LT(length_between(end_[i][v], nearest(end(exact(before_[i][v])))), (4096 * 0x1p-53 + 4 * unit_) * size())
            << "body " << i << ", fraction " << gone_[i];
    }
  }

  Tetrahedron at(size_t body, double t) const {
    Tetrahedron now;
    const ExactScrew::Moment moment = parts_[body].at(t);
    for (size_t v = 0; v < 4; ++v)
      now[v] = is_rigid(body) ? nearest(moment(exact(before_[body][v]))) : lerp(start_[body][v], end_[body][v], t);
    return now;
  }
  /// The floors of all pairs are no lower than the least distance at the start.
  void judge(double t, Judged& judged) const {
    std::vector<Tetrahedron> now;
    for (size_t i = 0; i < kCount; ++i) now.push_back(at(i, t));
    for (size_t i = 0; i < kCount; ++i)
      for (size_t j = 0; j < i; ++j, ++judged.ways)
        ASSERT_GE(distance(now[i], now[j]), 7.0 / 8 * least_ * (1 - 1e-6) - 4 * unit_ * size())
            << "bodies " << i << " and " << j << ", at " << t << ", mode " << static_cast<int>(mode_);
  }

  /// A vertex on its way to where it is aimed at.
  Vec3d aimed_at(uint32_t vertex, double t) const {
    const size_t body = vertex / 4, v = vertex % 4;
    if (is_rigid(body)) return nearest(screws_[body].at(t)(exact(before_[body][v])));
    const bool stands = motion_of(body) == MeshMotion::kStatic;
    return lerp(start_[body][v], stands ? start_[body][v] : targets_[body].at[v], t);
  }
  /// Pairs that limit the way are no nearer than their floors before the times that they have.
  void judge_limits(Judged& judged) const {
    const PerKind<ContactSet>& limits = bodies_.result().limits;
    const Topology& topology = bodies_.topology();
    for (size_t i = 0; i < limits.vertex_triangle.size(); ++i) {
      const auto [vertex, triangle] = limits.vertex_triangle.elements[i];
      const auto& [a, b, c] = topology.triangles[triangle];
      judge_limit(limits.vertex_triangle, i, judged, [&](double t) {
        return point_triangle(aimed_at(vertex, t), {aimed_at(a, t), aimed_at(b, t), aimed_at(c, t)}).distance;
      });
    }
    for (size_t i = 0; i < limits.edge_edge.size(); ++i) {
      const auto &e = topology.edges[limits.edge_edge.elements[i][0]],
                 &f = topology.edges[limits.edge_edge.elements[i][1]];
      judge_limit(limits.edge_edge, i, judged, [&](double t) {
        return edge_edge({aimed_at(e[0], t), aimed_at(e[1], t)}, {aimed_at(f[0], t), aimed_at(f[1], t)}).distance;
      });
    }
  }
  template <class Distance>
  void judge_limit(const ContactSet& set, size_t i, Judged& judged, const Distance& distance_at) const {
    constexpr int kTimes = 6;
    ++judged.limits, judged.later_limits += set.toi[i] > 0;
    for (int time = 0; time <= kTimes && set.toi[i] > 0; ++time)
      ASSERT_GE(distance_at(set.toi[i] * time / kTimes), set.distance[i] * (1 - 1e-6) - 4 * unit_ * size())
          << "limit " << i << ", mode " << static_cast<int>(mode_);
  }

  Random random_;
  const double min_separation_, offset_, unit_;
  const AdvanceMode mode_;
  const bool turn_together_;
  Bodies bodies_;
  std::vector<ExactScrew> screws_, parts_;  ///< of a step: as they are aimed at, and as far as they go
  std::vector<Bodies::Target> targets_;
  std::vector<Tetrahedron> start_, end_, before_;  ///< resident at both ends; posed at the start, not rounded
  std::vector<double> gone_;
  double least_ = 0;  ///< distance of two bodies at the start, or the minimum separation
};

TEST_F(TurningAdvances, KeepTheirFloorsOnTheirScrews) {
  Judged judged;
  for (uint32_t seed = 1; seed <= 60 && !HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const SceneSpec how = settings(Mode::kCcd, seed % 5 == 0 ? Accuracy::kExact : Accuracy::kCertified,
                                   seed % 3 == 0 ? Scalar::kF32 : Scalar::kF64);
    Crowd crowd(seed, seed % 4 == 0 ? in_parts(how, 2) : how);
    for (int step = 0; step < 4 && !HasFailure(); ++step) crowd.step(judged);
  }
  std::printf("%d steps, %d distances, %d of %d rigid bodies shortened, mean fraction %.3f\n", judged.steps,
              judged.ways, judged.shortened, judged.rigid, judged.share / judged.rigid);
  EXPECT_GT(judged.shortened, judged.rigid / 4);
  EXPECT_GT(judged.share, 0.3 * judged.rigid);
  std::printf("%d limits, %d of them not at the start\n", judged.limits, judged.later_limits);
  EXPECT_GT(judged.later_limits, 200);
}

// One fraction for all, of bodies that are not the first.
TEST_F(TurningAdvances, WithOneFractionSlidingBodiesStopWithTheScene) {
  const Tetrahedron floor = {Vec3d{-20, -20, 0}, {20, -20, 0}, {0, 20, 0}, {0, 0, -20}};
  const Tetrahedron body = {Vec3d{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {0, 0, 2}},
                    beside = {Vec3d{5, 5, 1}, {6, 5, 1}, {5, 6, 1}, {5, 5, 2}};
  Bodies bodies({{floor, MeshMotion::kStatic}, {body}, {beside}}, 1e-3, settings(Mode::kCcd, Accuracy::kCertified));
  Bodies::Target down, aside;
  down.pose.rows[11] = -2, aside.pose.rows[3] = 1;
  const double gone = bodies.advance({{}, down, aside}, AdvanceMode::kAllOrOne)[1];
  EXPECT_NEAR(gone, 0.5, 0.01);
  EXPECT_EQ(posed(bodies[1].pose, body), bodies.resident(1));
  EXPECT_EQ(posed(bodies[2].pose, beside), bodies.resident(2));
  EXPECT_GT(distance(floor, bodies.resident(1)), 0);
}

/// Families of turns for poses on the way.
TEST(PoseAlong, IsOnTheScrewBesideTheChord) {
  Random random(7);
  double off_rotation = 0;
  for (int i = 0; i < 2000; ++i) {
    ExactScrew whole =
        screw_about(random.vector(1), random.vector(std::pow(10, random.within(-2, 3))),
                    i % 2 == 0 ? random.within(0, 3) : std::pow(10, random.within(-14, 0)), random.within(-3, 3));
    const Pose from = moved({}, screw_about(random.vector(1), random.vector(1), random.within(0, 3)));
    const Pose to = moved(from, whole);
    const double a = random.within(0, 1);
    const Pose at = pose_along(from, to, a);
    off_rotation = std::max(off_rotation, rotation_defect(at));
    const Vec3d p = random.vector(1);
    const ExactVec expected = part_of(whole, a).at(1)(exact(posed(from, p)));
    const double size = 1 + length_of(posed(from, p)) + length_of(posed(to, p));
    EXPECT_LT(length_of(minus(posed(at, p), nearest(expected))), 1e-13 * size) << i;
  }
  EXPECT_LT(off_rotation, 1e-14);
}

// Each target is a turn of where the last advance ended, as solvers have it.
TEST(PoseAlong, StaysARotationOverManySteps) {
  Random random(11);
  for (const double angle : {0.01, 1.0, 2.99}) {
    Pose at;
    double most = 0;
    for (int step = 0; step < 2000; ++step) {
      const Pose turn = moved({}, screw_about(random.vector(1), {}, angle));
      Pose target;
      for (size_t i = 0; i < 3; ++i)
        for (size_t k = 0; k < 3; ++k)
          target.rows[4 * i + k] = (turn.rows[4 * i] * at.rows[k] + turn.rows[4 * i + 1] * at.rows[4 + k]) +
                                   turn.rows[4 * i + 2] * at.rows[8 + k];
      at = pose_along(at, target, random.unit());
      most = std::max(most, rotation_defect(at));
    }
    EXPECT_LT(most, 1e-11) << angle;
  }
}

TEST(PoseAlong, IsExactAtBothEndsAndBlendsWhatDoesNotTurn) {
  const Pose from = moved({}, screw_about({1, 2, 3}, {4, 5, 6}, 1)), to = moved(from, screw_about({1, 0, 3}, {}, 2));
  EXPECT_EQ(from.rows, pose_along(from, to, 0).rows);
  EXPECT_EQ(to.rows, pose_along(from, to, 1).rows);
  Pose slid = from;
  slid.rows[3] += 0.3, slid.rows[7] -= 1e9, slid.rows[11] *= 3;
  const Pose at = pose_along(from, slid, 0.3);
  for (size_t k = 0; k < 12; ++k) EXPECT_EQ(at.rows[k], from.rows[k] + 0.3 * (slid.rows[k] - from.rows[k])) << k;
}

// Boxes are grown by enough for all parts of the way (Deviations::of_parts).
TEST(PoseAlong, PartsOfTheWayAreWithinFourDeviations) {
  Random random(9);
  const auto corner = [](const Box<double>& box, int i) {
    return Vec3d{i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z};
  };
  double most = 0;
  for (int i = 0; i < 20000; ++i) {
    const double far = std::pow(10, random.within(-3, 3));
    const ExactScrew whole =
        screw_about(random.vector(1), random.vector(far),
                    i % 2 == 0 ? random.within(0, 3) : std::pow(10, random.within(-14, 0)), random.within(-3, 3));
    const Pose from = moved({}, screw_about(random.vector(1), random.vector(1), random.within(0, 3)));
    Pose to = moved(from, whole);
    if (i % 5 == 0)
      for (const size_t k : {0, 1, 2, 4, 5, 6, 8, 9, 10})
        to.rows[k] += random.within(-1, 1) * std::pow(10, random.within(-8, -4.9));
    if (from.has_rotation_of(to)) continue;
    const Vec3d lo = random.vector(far), size = random.vector(1);
    const Box<double> rest{{lo[0], lo[1], lo[2]},
                           {lo[0] + std::abs(size[0]), lo[1] + std::abs(size[1]), lo[2] + std::abs(size[2])}};
    const double a = i % 3 == 0 ? std::pow(10, random.within(-12, 0)) : random.within(0, 1);
    const Pose at = pose_along(from, to, a);
    double off = 0;
    for (int k = 0; k < 8; ++k) {
      const Vec3d p = corner(rest, k);
      off = std::max(off, length_of(minus(posed(at, p), lerp(posed(from, p), posed(to, p), a))));
    }
    most = std::max(most, (off + arc_deviation<double>(from, at, rest)) / arc_deviation<double>(from, to, rest));
  }
  std::printf("parts of the way are within %.3f deviations\n", most);
  EXPECT_LT(most, Deviations::kOfParts);
}

}  // namespace
}  // namespace collided::test
