// Contacts on the arcs of random screws, judged in 67 digits. A wall stands between the arc of a vertex and its
// straight path, so that nothing but the allowance for the arc finds the contact.

#include <cmath>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/exact_screw.hpp"
#include "tests/gpu/positions/owned_updates.hpp"

namespace collided::test {
namespace {

using Triangle = std::array<Vec3d, 3>;

/// A triangle whose first vertex is the farthest from the axis of its screw, along `outward`.
struct Body {
  size_t along;  ///< the axis of coordinates that the axis of the screw is parallel to, at rest
  Vec3d outward{};
  double size = 0;  ///< outward
  Triangle rest{};
};

struct ScrewAndWall {
  ExactScrew screw;
  Triangle wall{};
};

template <class Real>
class Draw {
 public:
  explicit Draw(uint32_t seed) : random_(seed) {}

  Body body() {
    Body body{random_() % 3};
    const double turn = between(-3, 3), size = power(kIsF64 ? -11 : -5, 0.3), length = between(0.01, 2);
    body.size = size;
    body.outward[(body.along + 1) % 3] = std::cos(turn), body.outward[(body.along + 2) % 3] = std::sin(turn);
    const Vec3d at = vector(random_() % 3 == 0 ? 1 : size);
    for (size_t i = 0; i < 3; ++i)
      for (size_t k = 0; k < 3; ++k)
        body.rest[i][k] = rounded_to<Real>(at[k] + (i == 0 ? 1 : between(-0.5, 0.7)) * size * body.outward[k] +
                               (k == body.along && i > 0 ? between(-length, length) : 0));
    return body;
  }

  /// None where rounding spoils what is wanted.
  std::optional<ScrewAndWall> screw_of(const Body& body) {
    if (random_() % 10 == 0) return slide_of(body);
    ExactScrew screw;
    screw.posed_about = unit(exact(vector(1)));
    screw.posed_by = exact(random_() % 2 * between(0, 3));  // axes of coordinates hide no rounding
    screw.posed_at = exact(vector(random_() % 4 == 0 ? 100 : 1));
    Vec3d e{};
    e[body.along] = 1;
    screw.axis = screw.direction(exact(e));
    const double radius = random_() % 2 == 0 ? between(0.5, 2) * body.size : power(-3, 2) * body.size;
    screw.centre = screw.at(0)(exact(body.rest[0])) - exact(radius) * screw.direction(exact(body.outward));
    const double angles[] = {between(0.01, 2.99), between(2.9, 2.9999), power(-6, 0)};
    screw.angle = exact(angles[random_() % 3]);
    screw.slide = exact(random_() % 5 == 0 ? 0 : between(-1, 1) * power(-1, 0.5));
    return wall_of(screw, body);
  }

 private:
  static constexpr bool kIsF64 = sizeof(Real) == sizeof(double);

  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double power(double low, double high) { return std::pow(10, between(low, high)); }
  Vec3d vector(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

  Triangle wall(const ExactVec& through, const ExactVec& normal, const Exact& size) const {
    const ExactVec side = unit(cross(normal, abs(normal[0]) < 0.7 ? exact(Vec3d{1, 0, 0}) : exact(Vec3d{0, 1, 0})));
    const ExactVec up = cross(normal, side);
    Triangle wall;
    for (int i = 0; i < 3; ++i) {
      const Angle turn(exact(2.1 * i));
      const Vec3d corner = nearest(through + (size * turn.cosine) * side + (size * turn.sine) * up);
      for (size_t k = 0; k < 3; ++k) wall[static_cast<size_t>(i)][k] = rounded_to<Real>(corner[k]);
    }
    return wall;
  }
  /// Sign of the side of the wall that a point is on.
  static int side_of(const Triangle& wall, const ExactVec& point) {
    const ExactVec a = exact(wall[0]);
    return sgn(dot(cross(exact(wall[1]) - a, exact(wall[2]) - a), point - a));
  }

  std::optional<ScrewAndWall> wall_of(const ExactScrew& screw, const Body& body) {
    const Pose from = screw.at(0).pose(), to = screw.at(1).pose();
    const ExactVec tip = exact(body.rest[0]), middle = screw.at(0.5)(tip), start = screw.at(0)(tip);
    const ExactVec end = screw.at(1)(tip), chord = 0.5 * (start + end), out = middle - chord;
    if (length(out) < 1e-60) return {};
    // The whole motion of the tip is within this of the middle, which the wall's inner circle exceeds.
    const Exact size = 4 * (length(end - start) + length(out));
    const ScrewAndWall made{screw, wall(chord + exact(between(0.5, 0.999)) * out, unit(out), size)};
    const int inner = side_of(made.wall, start);
    if (inner * side_of(made.wall, middle) >= 0) return {};
    for (const Vec3d& p : body.rest)
      for (const Pose* pose : {&from, &to})
        if (side_of(made.wall, exact(posed_by<Real>(*pose, p))) != inner) return {};
    return made;
  }

  /// A slide, and a wall across it.
  ScrewAndWall slide_of(const Body& body) {
    ExactScrew screw;
    screw.posed_about = unit(exact(vector(1)));
    screw.posed_by = exact(between(0, 3));
    screw.posed_at = exact(vector(1));
    screw.axis = unit(exact(vector(1)));
    screw.slide = exact(between(0.1, 3));
    return {screw, wall(screw.at(0.49)(exact(body.rest[0])), screw.axis, exact(30))};
  }

  std::mt19937 random_;
};

/// The body and the wall in a scene of their own, for one screw after another.
class Scene {
 public:
  Scene(const Body& body, Scalar scalar) : scalar_(scalar) {
    const Positions rest(body.rest.begin(), body.rest.end());
    Case c;
    for (int mesh = 0; mesh < 2; ++mesh) add_mesh(c, {{0, 1, 2}}, rest);
    SceneSpec spec = spec_for(c, settings(Mode::kCcd, Accuracy::kCertified, scalar));
    spec.meshes[0].motion = MeshMotion::kRigid;
    scene_ = Detector::create(spec);
    scene_->detect(frame_of({{0, false, {}, {}, packed(body.rest)}, {1, false, {}, {}, packed(body.rest)}}));
  }
  FrameResult step(const ScrewAndWall& to, Accuracy accuracy) {
    OwnedUpdate move, wall;
    wall.mesh = 1, wall.start = wall.end = packed(to.wall);
    move.transform = bytes_of(to.screw.at(1).pose()), move.start_transform = bytes_of(to.screw.at(0).pose());
    FrameInput input;
    input.updates = {move.view(), wall.view()};
    input.accuracy = accuracy;
    return scene_->detect(input);
  }

 private:
  std::vector<std::byte> packed(const Triangle& triangle) const {
    return pack({triangle.begin(), triangle.end()}, scalar_);
  }
  static std::vector<std::byte> bytes_of(const Pose& pose) {
    const auto* bytes = reinterpret_cast<const std::byte*>(pose.rows.data());
    return {bytes, bytes + sizeof(pose.rows)};
  }

  Scalar scalar_;
  std::unique_ptr<Detector> scene_;
};

template <class>
class ScrewContacts : public OnBackend<::testing::Test> {};
using Formats = ::testing::Types<float, double>;
TYPED_TEST_SUITE(ScrewContacts, Formats);

// Halfway the tip is beyond the wall, so no time after it is early enough.
TYPED_TEST(ScrewContacts, WhatAnArcTouchesIsReportedInTime) {
  Draw<TypeParam> draw(11);
  int screws = 0, missed = 0, late = 0;
  while (screws < 10000) {
    const Body body = draw.body();
    Scene scene(body, sizeof(TypeParam) == sizeof(double) ? Scalar::kF64 : Scalar::kF32);
    for (int i = 0; i < 50; ++i) {
      const std::optional<ScrewAndWall> made = draw.screw_of(body);
      if (!made) continue;
      ++screws;
      for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified}) {
        const FrameResult result = scene.step(*made, accuracy);
        missed += result.any_contact ? 0 : 1;
        late += result.any_contact && result.earliest_toi > 0.5 ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(0, missed);
  EXPECT_EQ(0, late);
}

}  // namespace
}  // namespace collided::test
