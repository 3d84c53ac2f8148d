#pragma once
// How far a scene can go towards a frame's positions p, from where it is, x, so that the straight way to where it ends,
// x' = blend(x, p, a), is certified free of contact: for x' as it is after rounding, not for the point it was rounded
// from.
//
// A way is tried, as any step is, at the frame's own level, for its earliest contact; the first one that has none is
// taken. So an advance never contradicts the frame's contacts. Features have to be `min_separation` apart on all of it;
// at CERTIFIED a little more at its end: the way's thickness grows linearly by `margin`. So the next step begins where
// the certificate holds, whatever it rounds, and features that part are free to. EXACT decides the next step from
// wherever it begins. Features that are closer than min_separation when the way begins may stay so if they come no
// closer (kFlagSeparating).

#include <cmath>

#include "gpu/boxes/records.hpp"
#include "gpu/state/settings.hpp"

namespace collided {

/// The fraction to try, from the earliest contact of the last try.
class AdvanceSearch {
 public:
  /// Of what is free, as little as keeps features from touching that come straight at each other.
  static constexpr double kLeft = 0x1p-7;

  /// `toi`: contact that is known of, in [0, 1]; 1: of none.
  explicit AdvanceSearch(double toi) {
    if (toi < 1) shorten(toi);
  }

  double fraction() const { return fraction_; }
  /// Whether fraction() may be tried; at 0 nothing moves.
  bool can_try() const { return fraction_ > 0 && tries_ < kMaxTries; }
  /// The way to fraction() is not free: it is up to `toi` of it, in [0, 1].
  void fail(double toi) {
    ++tries_;
    // What is free of the very last try is worth less than the time that it takes to find it.
    shorten(tries_ < kMaxTries ? toi : 0);
  }

 private:
  static constexpr int kMaxTries = 8;

  void shorten(double toi) { fraction_ *= toi * (1 - kLeft); }

  double fraction_ = 1;
  int tries_ = 0;
};

/// The box of a vertex's way.
template <class Real>
struct BoxOfWay {
  const Vec3<Real>* start;
  const Vec3<Real>* end;

  COLLIDED_HD Box<float> operator()(uint64_t i) const { return outward_float(Path<Real>{start[i], end[i]}.swept()); }
};

/// What features are farther apart than min_separation at the end of a way: 2^-40 of the size of a scene whose whole
/// way has these bounds, rounded up to a power of two. Certificates in double lose less than 2^-48 of a pair's size.
/// It is the frame's own and no earlier one's, as contacts must not depend on what else the scene went through.
inline double advance_margin(const Box<float>& bounds, double min_separation) {
  const Vec3<float> extent = bounds.hi - bounds.lo;
  const double size = std::fmax(extent.x, std::fmax(extent.y, extent.z)) + min_separation;
  if (!(size > 0) || !std::isfinite(size)) return 0x1p-1000;
  return std::ldexp(1.0, std::ilogb(size) + 1 - 40);
}

/// Returns the settings of the tries of an advance, for a frame at this level.
inline FrameSettings settings_of_try(const SceneSpec& spec, Accuracy accuracy, double margin) {
  return {Mode::kCcd, accuracy, 0, Report::kEarliestOnly, spec.min_separation + margin, spec.min_separation, true};
}

/// Whether a step without contacts that approach, with these settings, is as good as a try.
inline bool covers(const FrameSettings& settings, const FrameSettings& attempt) {
  return settings.accuracy >= attempt.accuracy && settings.start_thickness >= attempt.start_thickness &&
         settings.thickness >= attempt.thickness;
}

}  // namespace collided
