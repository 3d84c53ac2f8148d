#pragma once
// A scene and random frames for it: small and large motion, other levels, modes and reports, frames that are refused,
// edits.

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/scene/sheets.hpp"

namespace collided::test {

/// Two sheets, one with a loose edge and a particle, over a static one, beside a rigid one; some are thick by
/// themselves.
class RandomStream {
 public:
  static constexpr uint32_t kSide = 5;  ///< vertices of a sheet's side

  explicit RandomStream(uint32_t seed) : random_(seed) {
    constexpr Mode kModes[] = {Mode::kCcd, Mode::kDcd, Mode::kBoth};
    spec_ = settings(kModes[seed % 3], Accuracy::kCertified, seed / 3 % 2 == 0 ? Scalar::kF32 : Scalar::kF64,
                     seed % 4 == 0 && seed % 3 == 0 ? 0 : 0.05);
    spec_.threads = 1;
    if (spec_.mode != Mode::kDcd) spec_.min_separation = 0.01;
    spec_.fields = {ContactField::kElements, ContactField::kToi, ContactField::kDistance, ContactField::kFlags};
    for (int m = 0; m < 4; ++m) places_.push_back(shaken(flat_grid(kSide, 1), random(1u << 30), 0.2));
    for (int m = 0; m < 4; ++m)
      for (Vec3d& p : places_[static_cast<size_t>(m)]) p[0] += 0.3 * m, p[2] += 0.3 * m;
    spec_.meshes.assign(4, {kSide * kSide, grid_triangles(kSide)});
    spec_.meshes[0].motion = MeshMotion::kStatic;
    add_fringe(spec_.meshes[1], places_[1]);
    spec_.meshes[2].excluded_rings = random(2);
    spec_.meshes[2].excludes_rest_pairs = seed % 5 == 0;
    spec_.rest_distance = seed % 5 == 0 ? 0.3 : 0;
    spec_.meshes[3].motion = MeshMotion::kRigid;
    is_thick_ = seed % 4 == 1 || seed % 24 == 0;
    if (is_thick_) spec_.meshes[1].half_thickness = 0.06, spec_.meshes[3].half_thickness = 0.02;
  }

  const SceneSpec& spec() const { return spec_; }
  FrameInput first() {
    updates_.clear();
    for (uint32_t m = 0; m < 4; ++m) updates_.push_back({.mesh = m, .end = pack(places_[m], spec_.scalar)});
    return frame_of(updates_);
  }
  FrameInput next() {
    updates_.clear();
    const double by = random(8) == 0 ? 0.6 : random(8) == 0 ? 0 : 0.004;
    for (const uint32_t m : {1u, 2u}) move(m, by);
    if (random(2) == 0) turn(by);
    FrameInput input = frame_of(updates_);
    choose_options(input);
    if (random(10) == 0) edit(input);
    return input;
  }
  uint32_t random(uint32_t end) { return std::uniform_int_distribution<uint32_t>(0, end - 1)(random_); }

 private:
  static void add_fringe(MeshSpec& sheet, Positions& places) {
    sheet.edges = {{0, sheet.vertex_count}};
    sheet.points = {sheet.vertex_count + 1};
    places.push_back({places[0][0] + 0.5, places[0][1] + 0.75, places[0][2] + 0.25});
    places.push_back({places[0][0] + 1.5, places[0][1] + 0.5, places[0][2] + 0.5});
    sheet.vertex_count += 2;
  }
  bool is_continuous() const { return spec_.mode != Mode::kDcd; }

  /// All of its vertices, or a few; now and then with a number that no position may have.
  void move(uint32_t mesh, double by) {
    const Positions before = places_[mesh];
    Positions& places = places_[mesh];
    places = shaken(places, random(1u << 30), by);
    if (random(6) == 0)
      for (Vec3d& p : places) p[2] -= 2 * by;
    Positions end = places;
    if (random(24) == 0) end[random(kSide)][1] = std::numeric_limits<double>::quiet_NaN();
    if (random(3) > 0) {
      const bool has_start = is_continuous() && random(6) == 0;
      updates_.push_back(
          {.mesh = mesh,
           .start = has_start ? pack(shaken(before, random(1u << 30), by), spec_.scalar) : std::vector<std::byte>{},
           .end = pack(end, spec_.scalar)});
      return;
    }
    std::vector<uint32_t> indices;
    Positions some;
    for (uint32_t v = random(4); v < end.size(); v += 1 + random(5)) indices.push_back(v), some.push_back(end[v]);
    updates_.push_back(
        {.mesh = mesh, .is_sparse = true, .indices = bytes_of(indices), .end = pack(some, spec_.scalar)});
  }
  /// The rigid mesh, about an axis through its corner.
  void turn(double by) {
    angle_ += random(2) == 0 ? by : 0;
    const double c = std::cos(angle_), s = std::sin(angle_);
    shift_ += random(2) == 0 ? by : -by;
    const double rows[12] = {c, -s, 0, shift_, s, c, 0, 0, 0, 0, 1, shift_};
    const auto* bytes = reinterpret_cast<const std::byte*>(rows);
    updates_.push_back({.mesh = 3, .transform = {bytes, bytes + sizeof(rows)}});
  }
  void choose_options(FrameInput& input) {
    constexpr Accuracy kLevels[] = {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kExact};
    if (random(3) == 0) input.accuracy = kLevels[random(4)];
    if (spec_.mode == Mode::kBoth && random(2) == 0) input.mode = Mode::kDcd;
    const bool is_continuous = this->is_continuous() && input.mode != Mode::kDcd;
    const Accuracy level = input.accuracy.value_or(spec_.accuracy);
    if (random(6) == 0 && level > Accuracy::kCandidates) input.report = Report::kAnyHit;
    if (random(6) == 0 && is_continuous && level >= Accuracy::kGuarded) input.report = Report::kEarliestOnly;
    input.trial = random(8) == 0;
    input.advance = is_continuous && level >= Accuracy::kCertified && random(6) == 0;
  }
  /// Meshes that may touch no more, or again; a triangle that is torn out.
  void edit(FrameInput& input) {
    SceneEdit edit;
    if (random(2) == 0) {
      (is_excluded_ ? edit.included : edit.excluded).push_back({1, 2});
    } else {
      MeshSpec torn = spec_.meshes[2];
      torn.triangles.resize(torn.triangles.size() - random(3));
      if (is_thick_) torn.half_thickness = 0.01 * static_cast<double>(torn.triangles.size() % 3);
      edit.meshes.push_back({2, torn});
    }
    if (!input.trial) is_excluded_ = is_excluded_ != (edit.meshes.empty());
    input.edit = std::make_shared<const SceneEdit>(edit);
  }

  std::mt19937 random_;
  SceneSpec spec_;
  std::vector<Positions> places_;
  std::vector<OwnedUpdate> updates_;
  double angle_ = 0, shift_ = 0;
  bool is_excluded_ = false, is_thick_ = false;
};

/// A frame that is given up on its way.
inline void give_up(Detector& detector, FrameInput input, int asks) {
  input.trial = true;
  input.cancelled = [&] { return --asks < 0; };
  try {
    detector.detect(input);
  } catch (const Cancelled&) {
  } catch (const InvalidInput&) {
  }
}

}  // namespace collided::test
