// Meshes that are thick by themselves, against the exact judge: every level, engine and number of shards, distances at
// the limit and one double to either side of it, limits that are no doubles.

#include <algorithm>
#include <cmath>

#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/shards/one_and_shards.hpp"
#include "tests/support/adversarial.hpp"

namespace collided::test {
namespace {

using HalfThickness = OnBackend<>;

bool is_subset(const std::vector<PairKey>& part, const std::vector<PairKey>& whole) {
  return std::includes(whole.begin(), whole.end(), part.begin(), part.end());
}

/// A thick mesh, one that is not, hairs and particles between, and a wall that stands still.
Case thick_and_thin(uint32_t seed, bool is_lattice) {
  Case c = loose_soup(seed, 24, 1, 0.3, 0.15);
  const Case thick = soup(seed + 1, 20, 1, 0.3, 0.15), wall = soup(seed + 2, 16, 1, 0.4, 0);
  add_mesh(c, thick.meshes[0].triangles, thick.start[0], thick.end[0]);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  constexpr double kHalves[] = {0, 0.01, 0.003, 0.07, 0.02};
  constexpr double kOnLattice[] = {0, 0.25, 0.5, 1, 0.75};
  for (size_t mesh = 0; mesh < c.meshes.size(); ++mesh)
    c.meshes[mesh].half_thickness = is_lattice ? kOnLattice[mesh] : kHalves[mesh];
  if (!is_lattice) return c;
  for (std::vector<Positions>* all : {&c.start, &c.end})
    for (Positions& positions : *all)
      for (Vec3d& p : positions)
        for (double& x : p) x *= 6;
  return on_integers(std::move(c));
}

struct Truths {
  Truth vertex_triangle, edge_edge;

  size_t size() const { return vertex_triangle.size() + edge_edge.size(); }
};

/// Of all pairs whose boxes are within the largest distance of any pair, found without the engine.
Truths truths_of(const Case& c, Mode mode, Scalar scalar, double thickness) {
  double thickest = 0;
  for (const MeshSpec& mesh : c.meshes) thickest = std::max(thickest, mesh.half_thickness);
  const ExpectedPairs near = brute_force(c, mode, scalar, thickness + 2 * thickest);
  const CaseJudge judge(c, mode, thickness);
  const auto pairs = [](const PairSet& set) {
    std::vector<std::array<uint32_t, 2>> out;
    for (const PairKey key : set.may) out.push_back({static_cast<uint32_t>(key >> 32), static_cast<uint32_t>(key)});
    return out;
  };
  return {judge.vertex_triangle(pairs(near.vertex_triangle)), judge.edge_edge(pairs(near.edge_edge))};
}

void expect_promises(const ContactSet& contacts, const Truth& truth, Mode mode) {
  const std::vector<PairKey> keys = keys_of(contacts), true_keys = keys_of(truth);
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end(), std::less_equal<>()));
  EXPECT_TRUE(is_subset(true_keys, keys)) << "missed";
  for (size_t i = 0; i < keys.size(); ++i) {
    const auto judged = truth.find(keys[i]);
    if (judged == truth.end()) {
      EXPECT_EQ(contacts.flags[i] & kFlagCertified, 0) << "certain, but no contact";
    } else if (mode == Mode::kCcd) {
      EXPECT_LE(mpq_class(contacts.toi[i]), judged->second.upper) << "late";
    }
  }
}

struct Question {
  std::string name;
  Mode mode;
  double thickness;
  bool is_lattice;
};
void PrintTo(const Question& question, std::ostream* out) { *out << question.name; }

class ThickLevels : public OnBackend<::testing::TestWithParam<std::tuple<Question, Scalar>>> {};

TEST_P(ThickLevels, KeepTheirPromises) {
  const auto& [question, scalar] = GetParam();
  const Case c = rounded(thick_and_thin(300, question.is_lattice), scalar);
  const Truths truth = truths_of(c, question.mode, scalar, question.thickness);
  EXPECT_GT(truth.size(), 100u);
  for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
    SCOPED_TRACE(level_name(accuracy));
    SceneSpec spec = spec_for(c, settings(question.mode, accuracy, scalar, question.thickness));
    const Frame frame(c, question.mode, scalar);
    const FrameResult r = Detector::create(spec)->detect(frame.input());
    expect_promises(r.vertex_triangle, truth.vertex_triangle, question.mode);
    expect_promises(r.edge_edge, truth.edge_edge, question.mode);
    if (accuracy == Accuracy::kExact) {
      EXPECT_EQ(keys_of(r.vertex_triangle), keys_of(truth.vertex_triangle));
      EXPECT_EQ(keys_of(r.edge_edge), keys_of(truth.edge_edge));
    }
    for (Engine engine : {Engine::kOctree, Engine::kUniformGrid, Engine::kLbvh, Engine::kAllPairs}) {
      spec.engine = engine;
      const FrameResult same = Detector::create(spec)->detect(frame.input());
      EXPECT_TRUE(same_contacts(r, same)) << static_cast<int>(engine);
      EXPECT_EQ(r.counts.candidates, same.counts.candidates);
    }
    EXPECT_TRUE(same_contacts(r, Detector::create(in_parts(spec, 3))->detect(frame.input())));
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, ThickLevels,
                         ::testing::Combine(::testing::Values(Question{"Discrete", Mode::kDcd, 0x1p-6, false},
                                                              Question{"DiscreteThin", Mode::kDcd, 0, false},
                                                              Question{"DiscreteLattice", Mode::kDcd, 0.5, true},
                                                              Question{"Continuous", Mode::kCcd, 0x1p-6, false},
                                                              Question{"ContinuousThin", Mode::kCcd, 0, false},
                                                              Question{"ContinuousLattice", Mode::kCcd, 0, true}),
                                            ::testing::Values(Scalar::kF32, Scalar::kF64)),
                         [](const auto& info) {
                           const bool is_float = std::get<1>(info.param) == Scalar::kF32;
                           return std::get<0>(info.param).name + (is_float ? "F32" : "F64");
                         });

// FAST promises nothing, but it means the same distances: it is right about pairs that are clearly near or apart.
TEST_F(HalfThickness, IsWhatFastMeansToo) {
  constexpr double kThickness = 0x1p-6, kSlack = 1e-3;
  const Case c = rounded(thick_and_thin(310, false), Scalar::kF32);
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    const FrameResult r = run_case(c, settings(mode, Accuracy::kFast, Scalar::kF32, kThickness));
    const auto truths = [&](double by) {
      Case changed = c;
      for (MeshSpec& mesh : changed.meshes) mesh.half_thickness *= by;
      return truths_of(changed, mode, Scalar::kF32, by * kThickness);
    };
    const Truths may = truths(1 + kSlack), must = truths(1 - kSlack);
    EXPECT_TRUE(is_subset(keys_of(r.vertex_triangle), keys_of(may.vertex_triangle)));
    EXPECT_TRUE(is_subset(keys_of(r.edge_edge), keys_of(may.edge_edge)));
    if (mode == Mode::kDcd) {
      EXPECT_TRUE(is_subset(keys_of(must.vertex_triangle), keys_of(r.vertex_triangle)));
      EXPECT_TRUE(is_subset(keys_of(must.edge_edge), keys_of(r.edge_edge)));
    } else {
      EXPECT_GT(count_contacts(r), must.size() / 2) << "its times are those at which four vertices are coplanar";
    }
    EXPECT_GT(must.size(), 100u);
  }
}

/// Features of two meshes that are `gap` apart, or come to be: a particle over a triangle, or two hairs that cross. The
/// feet are inside.
Case apart_by(double gap, bool is_vertex_triangle, const std::array<double, 2>& halves) {
  const double size = 4 * std::max(gap, 0x1p-1000);
  Case c;
  const Positions low = is_vertex_triangle ? Positions{{-size, -size, 0}, {2 * size, -size, 0}, {-size, 2 * size, 0}}
                                           : Positions{{-size, 0, 0}, {size, 0, 0}};
  const auto above = [&](double z) {
    return is_vertex_triangle ? Positions{{0, 0, z}} : Positions{{0, -size, z}, {0, size, z}};
  };
  add_mesh(c, {}, low);
  add_mesh(c, {}, above(4 * gap), above(gap));
  if (is_vertex_triangle) {
    c.meshes[0].triangles = {{0, 1, 2}};
    c.meshes[1].points = {0};
  } else {
    c.meshes[0].edges = c.meshes[1].edges = {{0, 1}};
  }
  for (size_t mesh = 0; mesh < 2; ++mesh) c.meshes[mesh].half_thickness = halves[mesh];
  return c;
}

mpq_class sum_of(double a, double b, double c) { return mpq_class(a) + mpq_class(b) + mpq_class(c); }

// EXACT decides by the real sum, which is often no double: contacts are those up to it, itself included.
TEST_F(HalfThickness, LimitsAreRealSums) {
  struct Sum {
    double thickness, first, second;
  };
  constexpr double kLeast = 0x1p-1074;
  const Sum sums[] = {{0.1, 0.2, 0.3},        {0.3, 0.1, 0.2},
                      {1, 0x1p-53, 0x1p-53},  {1, 0x1p-53, 0},
                      {0x1p60, 0x1p-60, 0},   {0x1p60, 0x1p-60, 0x1p-60},
                      {0, 0.1, 0.2},          {0, 0x1p60, 0x1p-60},
                      {0.25, 0.5, 0.25},      {0, 0, 0.7},
                      {0.1, 0.1, 0.1},        {kLeast, kLeast, kLeast},
                      {0x1p-1022, kLeast, 0}, {1e300, 1e284, 1e-300}};
  size_t contacts = 0, misses = 0;
  for (const Sum& sum : sums)
    for (const bool is_vertex_triangle : {true, false})
      for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
        double gap = sum.thickness + sum.first + sum.second;
        for (int k = 0; k < 3; ++k) gap = std::nextafter(gap, 0);
        for (int k = 0; k < 7; ++k, gap = std::nextafter(gap, HUGE_VAL)) {
          const Case c = apart_by(gap, is_vertex_triangle, {sum.first, sum.second});
          const bool expected = mpq_class(gap) <= sum_of(sum.thickness, sum.first, sum.second);
          const FrameResult r = run_case(c, settings(mode, Accuracy::kExact, Scalar::kF64, sum.thickness));
          EXPECT_EQ(r.any_contact, expected) << sum.thickness << " + " << sum.first << " + " << sum.second << ", " << k
                                             << (is_vertex_triangle ? " VT" : " EE") << " " << static_cast<int>(mode);
          ++(expected ? contacts : misses);
          for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified}) {
            const FrameResult near = run_case(c, settings(mode, accuracy, Scalar::kF64, sum.thickness));
            EXPECT_TRUE(near.any_contact || !expected) << "missed at " << level_name(accuracy);
            const ContactSet& set = is_vertex_triangle ? near.vertex_triangle : near.edge_edge;
            if (!expected && set.size() > 0) {
              EXPECT_EQ(set.flags[0] & kFlagCertified, 0);
            }
          }
        }
      }
  EXPECT_GT(contacts, 100u);
  EXPECT_GT(misses, 100u);
}

// A mesh counts twice where it touches itself.
TEST_F(HalfThickness, CountsTwiceInAMeshItself) {
  for (const double half : {0.1, 0.3, 0x1p-7})
    for (const double thickness : {0.0, 0.2}) {
      const mpq_class limit = sum_of(thickness, half, half);
      for (double gap : {limit.get_d(), std::nextafter(limit.get_d(), 0), std::nextafter(limit.get_d(), 9)}) {
        Case c;
        add_mesh(c, {}, {{-1, 0, 0}, {1, 0, 0}, {0, -1, gap}, {0, 1, gap}});
        c.meshes[0].edges = {{0, 1}, {2, 3}};
        c.meshes[0].half_thickness = half;
        const FrameResult r = run_case(c, settings(Mode::kDcd, Accuracy::kExact, Scalar::kF64, thickness));
        EXPECT_EQ(r.edge_edge.size() == 1, mpq_class(gap) <= limit) << half << " " << thickness << " " << gap;
      }
    }
}

}  // namespace
}  // namespace collided::test
