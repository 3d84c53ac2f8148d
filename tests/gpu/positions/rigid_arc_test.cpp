// The allowance for the arc of a rigid mesh, judged by screws in 67 digits: it covers every screw, and is little more
// than the deviation itself.

#include "gpu/positions/rigid_arc.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/gpu/positions/exact_screw.hpp"

namespace collided::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Families of screws, by what each has more of than the others.
enum class Kind {
  kAny,
  kThin,
  kLong,
  kOffAxis,
  kSmallAngle,
  kNearThree,
  kNearPi,
  kNoSlide,
  kOnlyNoise,
  kFarAway,
  kFarAtRest,
  kStretched,
  kScaled,
  kCount
};

template <class Real>
class RandomScrew {
 public:
  RandomScrew(std::mt19937& random, Kind kind) : random_(random) {
    const size_t along = static_cast<size_t>(random() % 3);
    Vec3d half = {between(0.01, 1), between(0.01, 1), between(0.01, 1)}, at = vector(5), off = vector(5);
    double slide = between(-5, 5), angle = between(0.01, 3), posed_at = 5;
    bool is_aligned = false;
    Vec3d stretch{};
    switch (kind) {
      case Kind::kThin: {
        const double radius = power(kIsF64 ? -16 : -8, -1);
        for (double& h : half) h *= radius;
        half[along] /= radius;
        is_aligned = true, slide = 1, posed_at = random() % 2;
        at = scaled(vector(1), radius), off = scaled(vector(2), radius);
        break;
      }
      case Kind::kLong: half[along] = power(0, 8), is_aligned = true; break;
      case Kind::kOffAxis: off = scaled(vector(1), power(0, 12)), angle = power(-12, 0.4); break;
      case Kind::kSmallAngle: angle = power(-18, -3); break;
      case Kind::kNearThree: angle = 3 + power(-16, -2) * between(-1, 1); break;
      case Kind::kNearPi: angle = kPi - power(-20, -1); break;
      case Kind::kNoSlide: slide = 0; break;
      case Kind::kOnlyNoise: angle = 0, stretch = scaled(vector(1), 0x1p-51); break;
      case Kind::kFarAway: posed_at = power(2, 12); break;
      case Kind::kFarAtRest: at = scaled(at, power(2, 12)); break;
      case Kind::kStretched: stretch = scaled(vector(1), power(-10, -4.7)); break;
      default: break;
    }
    const double scale = kind != Kind::kScaled ? 1 : kIsF64 ? power(-315, 300) : power(-44, 34);
    for (size_t k = 0; k < 3; ++k) {
      low_[k] = rounded_to<Real>((at[k] - half[k]) * scale);
      high_[k] = rounded_to<Real>((at[k] + half[k]) * scale);
    }
    screw_.posed_about = unit(exact(vector(1)));
    screw_.posed_by = exact(random() % 4 == 0 ? 0 : between(0, kPi));
    screw_.posed_at = exact(scaled(vector(posed_at), scale));
    Vec3d e{};
    e[along] = 1;
    screw_.axis = is_aligned ? screw_.direction(exact(e)) : unit(exact(vector(1)));
    screw_.centre = screw_.at(0)(exact(scaled(at, scale)) + exact(scaled(off, scale)));
    screw_.angle = exact(angle), screw_.slide = exact(slide) * scale;
    from_ = screw_.at(0).pose(stretch), to_ = screw_.at(1).pose({-stretch[1], stretch[0], stretch[2]});
  }

  /// False where the turn is too small for doubles: the engine then sees a slide.
  bool turns() const { return !from_.has_rotation_of(to_); }
  double allowed() const {
    return arc_deviation<Real>(from_, to_, {{low_[0], low_[1], low_[2]}, {high_[0], high_[1], high_[2]}});
  }
  /// The largest distance of a corner from its straight path: halfway, and at another time or an end.
  Exact deviation() {
    const double others[] = {0, 1, between(0, 1), between(0, 1)};
    return std::max(deviation_at(0.5), deviation_at(others[random_() % 4]));
  }

 private:
  static constexpr bool kIsF64 = sizeof(Real) == sizeof(double);

  static Vec3d scaled(const Vec3d& v, double s) { return {v[0] * s, v[1] * s, v[2] * s}; }
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double power(double low, double high) { return std::pow(10, between(low, high)); }
  Vec3d vector(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

  Exact deviation_at(double t) const {
    const ExactScrew::Moment moment = screw_.at(t);
    Exact largest = exact(0);
    for (int i = 0; i < 8; ++i) {
      const Vec3d p = {i & 1 ? high_[0] : low_[0], i & 2 ? high_[1] : low_[1], i & 4 ? high_[2] : low_[2]};
      const ExactVec a = exact(posed_by<Real>(from_, p)), b = exact(posed_by<Real>(to_, p));
      largest = std::max(largest, length(moment(exact(p)) - (a + exact(t) * (b - a))));
    }
    return largest;
  }

  std::mt19937& random_;
  ExactScrew screw_;
  Vec3d low_{}, high_{};
  Pose from_, to_;
};

double median(std::vector<double> of) {
  std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2), of.end());
  return of[of.size() / 2];
}

template <class Real>
class RigidArcIn : public ::testing::Test {};
using Formats = ::testing::Types<float, double>;
TYPED_TEST_SUITE(RigidArcIn, Formats);

// 20,800 screws in each format. What a screw deviates by is rounding alone where the arc is smaller than that; such
// kinds have ratios of up to 50 in the median, so that the median of all is what says that the bound is sharp.
TYPED_TEST(RigidArcIn, CoversEveryScrewAndIsLittleMore) {
  std::mt19937 random(3);
  std::vector<double> ratios, of_thin;
  for (int kind = 0; kind < static_cast<int>(Kind::kCount); ++kind)
    for (int i = 0; i < 1600; ++i) {
      RandomScrew<TypeParam> screw(random, static_cast<Kind>(kind));
      if (!screw.turns()) continue;
      const double allowed = screw.allowed();
      const Exact deviation = screw.deviation();
      ASSERT_GE(exact(allowed), deviation) << "kind " << kind << ", screw " << i;
      ratios.push_back(Exact(allowed / deviation).get_d());
      if (kind == static_cast<int>(Kind::kThin)) of_thin.push_back(ratios.back());
    }
  EXPECT_GT(ratios.size(), 20000u);
  EXPECT_LT(median(ratios), 1.001);
  EXPECT_LT(median(of_thin), 1.02);
}

/// Turned by `angle` about the z axis.
Pose turned_about_z(double angle) {
  ExactScrew screw;
  screw.angle = exact(angle);
  return screw.at(1).pose();
}

TEST(RigidArc, IsNothingWithoutATurn) {
  Pose moved;
  moved.rows[3] = 7;
  EXPECT_EQ(0, arc_deviation<double>({}, moved, {{-1, -1, -1}, {1, 1, 1}}));
  for (const double angle : {1e-9, 0.1, 2.5, 3.0}) EXPECT_NEAR(angle, angle_between({}, turned_about_z(angle)), 1e-14);
  EXPECT_LT(rotation_defect(turned_about_z(2.5)), 1e-15);
}

}  // namespace
}  // namespace collided::test
