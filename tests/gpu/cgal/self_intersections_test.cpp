// Meshes with themselves, at EXACT, against CGAL: triangle pairs are CGAL's, and so are the pairs that edges through
// triangles make, but for pairs that only touch, which may be no crossings.

#include "tests/gpu/cgal/self_intersections.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/narrow/crossing_judge.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

using Corners = std::array<uint32_t, 3>;
using Pairs = std::vector<PairKey>;

/// All meshes of a case, where they end, as one.
Case as_one_mesh(const Case& c) {
  const Features features = features_of(c);
  Positions positions;
  for (const Positions& mesh : c.end) positions.insert(positions.end(), mesh.begin(), mesh.end());
  Case one;
  add_mesh(one, features.triangles, positions);
  return one;
}

/// The first or the second one of two frames.
Case frame_of(const RealFrames& frames, bool is_second) {
  Case c = load(frames);
  if (!is_second) c.end = c.start;
  return c;
}

struct Surface {
  std::string name;
  std::function<Case()> make;  ///< of one mesh
  bool is_degenerate = false;  ///< some triangles have no area, others lie on each other about a common side
  bool is_here = true;
};

// GoogleTest prints parameter values with it.
void PrintTo(const Surface& surface, std::ostream* out) { *out << surface.name; }

Case far_from_the_origin() {
  Case c = crumpled(4, 30, 1.2);
  for (Vec3d& p : c.end[0])
    for (double& x : p) x += 0x1p30;
  return c;
}

std::vector<Surface> surfaces() {
  std::vector<Surface> all{{"Crumpled", [] { return crumpled(3, 70, 0.8); }},
                           {"FarFromTheOrigin", far_from_the_origin},
                           {"OnIntegers", [] { return on_integers(crumpled(5, 30, 1.5)); }, true}};
  for (const std::string& name : scene_names())
    all.push_back({name, [name] { return as_one_mesh(case_of(*scenes::make_scene(name, 0.4), 0.5, 0.6)); }});
  for (const RealFrames& frames : {kDrapeFrames, kFunnelFrames, kBallFrames})
    for (const bool is_second : {false, true})
      all.push_back({std::string(frames.name) + (is_second ? "_second" : "_first"),
                     [=] { return frame_of(frames, is_second); }, false, are_here(frames)});
  return all;
}

bool share_a_side(const Corners& a, const Corners& b) {
  return std::ranges::count_if(a, [&](uint32_t v) { return std::ranges::find(b, v) != b.end(); }) > 1;
}

/// Two triangles that share a vertex at most.
class Pair {
 public:
  Pair(const Positions& positions, const Corners& a, const Corners& b) : positions_(positions) {
    look(a, b);
    look(b, a);
  }
  /// No edge of one goes through the other for sure, and at least one would if ties were broken otherwise.
  bool only_touches() const { return through_ == 0 && tied_ > 0; }

 private:
  void look(const Corners& edges, const Corners& t) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = edges[k], w = edges[(k + 1) % 3];
      if (std::ranges::count(t, v) + std::ranges::count(t, w) > 0) continue;
      const std::optional<bool> answer =
          goes_through({positions_[v], positions_[w]}, {positions_[t[0]], positions_[t[1]], positions_[t[2]]});
      through_ += answer == true, tied_ += !answer;
    }
  }

  const Positions& positions_;
  int through_ = 0, tied_ = 0;
};

class AgainstCgal : public OnBackend<::testing::TestWithParam<Surface>> {
 protected:
  void SetUp() override {
    OnBackend::SetUp();
    if (!has_cgal()) GTEST_SKIP() << "built without CGAL (Debian: libcgal-dev)";
    if (!GetParam().is_here) GTEST_SKIP() << kNoDataFolder;
  }
};

SceneSpec crossings_of(const Case& c) {
  SceneSpec spec = settings(Mode::kDcd, Accuracy::kExact);
  spec.kinds = {.triangle_triangle = true, .edge_triangle = true};
  return spec_for(c, spec);
}

void expect_same_pairs(const Surface& surface, const Case& c) {
  const auto detector = Detector::create(crossings_of(c));
  const FrameResult result = detector->detect(Frame(c, Mode::kDcd, Scalar::kF64).input());
  const std::vector<Corners>& triangles = detector->topology().triangles;
  const SelfIntersections found = self_intersections(c.end[0], triangles);
  // CGAL has no pairs of triangles without area, and pairs that lie on each other about a common side.
  Pairs expected, pairs = keys_of(result.triangle_triangle);
  std::ranges::copy_if(found.pairs, std::back_inserter(expected), [&](PairKey key) {
    return !share_a_side(triangles[key >> 32], triangles[static_cast<uint32_t>(key)]);
  });
  const size_t folds = found.pairs.size() - expected.size(), all = pairs.size();
  const auto has_area = [&](uint32_t t) { return !std::ranges::binary_search(found.no_area, t); };
  std::erase_if(pairs, [&](PairKey key) {
    return !has_area(static_cast<uint32_t>(key >> 32)) || !has_area(static_cast<uint32_t>(key));
  });
  EXPECT_EQ(pairs, expected);
  EXPECT_EQ(folds > 0, surface.is_degenerate);
  EXPECT_EQ(found.no_area.size() > 0, surface.is_degenerate);
  Pairs of_crossings;
  for (const auto& [pair, ends] : contour_ends(result.edge_triangle.elements, detector->topology()))
    of_crossings.push_back(pair);
  EXPECT_TRUE(std::ranges::includes(keys_of(result.triangle_triangle), of_crossings));
  Pairs others;
  std::ranges::set_difference(expected, of_crossings, std::back_inserter(others));
  for (const PairKey key : others)
    EXPECT_TRUE(Pair(c.end[0], triangles[key >> 32], triangles[static_cast<uint32_t>(key)]).only_touches()) << key;
  std::printf(
      "%s: %zu triangles, %zu pairs of CGAL's, %zu of ours; %zu only touch; besides %zu of %zu triangles without area, "
      "and "
      "%zu folds\n",
      surface.name.c_str(), triangles.size(), expected.size(), pairs.size(), others.size(), all - pairs.size(),
      found.no_area.size(), folds);
}

TEST_P(AgainstCgal, PairsAreTheSame) { expect_same_pairs(GetParam(), GetParam().make()); }

INSTANTIATE_TEST_SUITE_P(Meshes, AgainstCgal, ::testing::ValuesIn(surfaces()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace collided::test
