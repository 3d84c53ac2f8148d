// Real simulations: the number of candidates is known, and so is every pair that collides.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "gpu/positions/blend.hpp"
#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/frames/frame_truth.hpp"

namespace collided::test {
namespace {

struct Golden {
  RealFrames frames;
  size_t vertex_triangle, edge_edge;  ///< candidates: closed swept boxes in double
  double least_free, least_way;       ///< of an advance: the share of vertices that go all the way, and of the motion
};

void PrintTo(const Golden& g, std::ostream* out) { *out << g.frames.name; }

const Golden kGolden[] = {{kDrapeFrames, 8766, 26661, 0.75, 0.9},
                          {kFunnelFrames, 7319, 33770, 0.985, 0.990},
                          {kBallFrames, 1655541, 5197332, 0.655, 0.72}};

using Times = std::map<PairKey, double>;  ///< of every pair that collides: what its time of impact is not above

struct FrameTimes {
  Times vertex_triangle, edge_edge;
};

/// Of the positions as they are given.
FrameTimes read_times(const RealFrames& frames, const Topology& topology) {
  const auto edge = [&](uint32_t a, uint32_t b) {
    const std::array<uint32_t, 2> key{std::min(a, b), std::max(a, b)};
    return static_cast<uint32_t>(std::lower_bound(topology.edges.begin(), topology.edges.end(), key) -
                                 topology.edges.begin());
  };
  FrameTimes times;
  const std::vector<LabelledQuery> queries = read_frame_queries(frames);
  size_t i = 0;
  for (const TruthRow& row : read_truth(frames, QueryKind::kVertexTriangle)) {
    const LabelledQuery& query = queries[i++];
    if (query.hit) times.vertex_triangle[key_of(row.ids[0], row.ids[1])] = query.toi_upper;
  }
  for (const TruthRow& row : read_truth(frames, QueryKind::kEdgeEdge)) {
    const uint32_t e = edge(row.ids[0], row.ids[1]), f = edge(row.ids[2], row.ids[3]);
    const LabelledQuery& query = queries[i++];
    if (query.hit) times.edge_edge[key_of(std::min(e, f), std::max(e, f))] = query.toi_upper;
  }
  return times;
}

Times times_of(const Truth& truth) {
  Times times;
  for (const auto& [pair, impact] : truth) times[pair] = std::nextafter(impact.upper.get_d(), 2.0);
  return times;
}

struct Score {
  size_t expected = 0, found = 0, right = 0, late = 0;
  size_t missed() const { return expected - right; }
  size_t false_ones() const { return found - right; }
  Score& operator+=(const Score& o) {
    expected += o.expected, found += o.found, right += o.right, late += o.late;
    return *this;
  }
};

Score score_of(const ContactSet& contacts, const Times& truth) {
  Score score{truth.size(), contacts.size(), 0, 0};
  for (size_t i = 0; i < contacts.size(); ++i) {
    const auto at = truth.find(key_of(contacts.elements[i][0], contacts.elements[i][1]));
    if (at == truth.end()) continue;
    ++score.right;
    if (contacts.toi[i] > at->second) ++score.late;
  }
  return score;
}

class RealFramesTest : public ::testing::TestWithParam<std::tuple<Golden, Backend>> {
 protected:
  void SetUp() override {
    if (backend() == Backend::kCuda && !cuda_available()) GTEST_SKIP() << "no CUDA device can be used";
    if (!are_here(golden().frames)) GTEST_SKIP() << kNoDataFolder;
    case_ = load(golden().frames);
  }
  const Golden& golden() const { return std::get<0>(GetParam()); }
  Backend backend() const { return std::get<1>(GetParam()); }
  SceneSpec spec(Accuracy accuracy, Scalar scalar) const {
    SceneSpec s = settings(Mode::kCcd, accuracy, scalar);
    s.device.backend = backend();
    return s;
  }

  /// Score of a level on the positions rounded to the scalar type.
  Score run(Accuracy accuracy, Scalar scalar, const FrameTimes& truth) {
    const FrameResult r = run_case(rounded(case_, scalar), spec(accuracy, scalar));
    Score score = score_of(r.vertex_triangle, truth.vertex_triangle);
    score += score_of(r.edge_edge, truth.edge_edge);
    std::printf("%s %s level %d: %zu contacts in truth, %zu missed, %zu false, %zu late\n", golden().frames.name,
                scalar == Scalar::kF32 ? "F32" : "F64", static_cast<int>(accuracy), score.expected, score.missed(),
                score.false_ones(), score.late);
    return score;
  }
  /// Of positions that are not those of the files once they are rounded: asks the judge about every candidate.
  FrameTimes truth_of(Scalar scalar) {
    const auto detector = Detector::create(spec_for(case_, spec(Accuracy::kCandidates, Scalar::kF64)));
    const Case as_given = rounded(case_, scalar);
    if (as_given.start == case_.start && as_given.end == case_.end)
      return read_times(golden().frames, detector->topology());
    const FrameResult r = run_case(as_given, spec(Accuracy::kCandidates, scalar));
    const CaseJudge judge(as_given, Mode::kCcd, 0);
    return {times_of(judge.vertex_triangle(r.vertex_triangle.elements)),
            times_of(judge.edge_edge(r.edge_edge.elements))};
  }

  Case case_;
};

TEST_P(RealFramesTest, CandidatesAreTheGoldenCounts) {
  const FrameResult r = run_case(case_, spec(Accuracy::kCandidates, Scalar::kF64));
  EXPECT_EQ(r.vertex_triangle.size(), golden().vertex_triangle);
  EXPECT_EQ(r.edge_edge.size(), golden().edge_edge);
}

TEST_P(RealFramesTest, CandidatesEqualBruteForce) {
  const FrameResult r = run_case(case_, spec(Accuracy::kCandidates, Scalar::kF64));
  const ExpectedPairs expected = brute_force(case_, Mode::kCcd, Scalar::kF64, 0);
  EXPECT_EQ(expected.vertex_triangle.must.size(), golden().vertex_triangle);
  EXPECT_EQ(expected.edge_edge.must.size(), golden().edge_edge);
  EXPECT_EQ("", compare(r.vertex_triangle.elements, expected.vertex_triangle));
  EXPECT_EQ("", compare(r.edge_edge.elements, expected.edge_edge));
}

// FAST promises nothing; these bounds only tell a working narrow phase from a broken one.
TEST_P(RealFramesTest, FastFindsNearlyAll) {
  const Score score = run(Accuracy::kFast, Scalar::kF64, truth_of(Scalar::kF64));
  EXPECT_LE(score.missed(), score.expected / 20);
  EXPECT_LE(score.false_ones(), score.expected);
}

TEST_P(RealFramesTest, CertifiedLevelsMissNothing) {
  for (Scalar scalar : {Scalar::kF32, Scalar::kF64}) {
    const FrameTimes truth = truth_of(scalar);
    for (Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
      const Score score = run(accuracy, scalar, truth);
      EXPECT_EQ(score.missed(), 0u);
      EXPECT_EQ(score.late, 0u);
      // Tight-Inclusion at tolerance 1e-6 reports 226 on both pairs of frames.
      EXPECT_TRUE(accuracy == Accuracy::kGuarded || score.false_ones() <= (accuracy == Accuracy::kExact ? 0 : 10));
    }
  }
}

// A first frame whose way is full of contacts: each vertex goes as far as it can. What is left of the ways is free,
// which the exact level decides.
TEST_P(RealFramesTest, VerticesGoAsFarAsTheyCan) {
  SceneSpec scene = spec(Accuracy::kCertified, Scalar::kF64);
  const auto detector = Detector::create(spec_for(case_, scene));
  const Frame frame(case_, Mode::kCcd, Scalar::kF64);
  FrameInput input = frame.input();
  input.advance = true;
  input.advance_mode = AdvanceMode::kPerVertex;
  const FrameResult gone = detector->detect(input);
  const size_t vertices = case_.start[0].size();
  Case left = case_;
  for (size_t i = 0; i < gone.shortened.ids.size(); ++i) {
    const uint32_t v = gone.shortened.ids[i];
    for (size_t k = 0; k < 3; ++k)
      left.end[0][v][k] = blend(case_.start[0][v][k], case_.end[0][v][k], gone.shortened.fractions[i]);
  }
  const double free = 1 - static_cast<double>(gone.shortened.ids.size()) / static_cast<double>(vertices);
  std::printf("%s: %.4f of the vertices go all the way, %.4f of the motion is gone, least fraction %g\n",
              golden().frames.name, free, gone.way, *gone.advanced);
  EXPECT_GE(free, golden().least_free);
  EXPECT_GE(gone.way, golden().least_way);
  const FrameResult judged = run_case(left, spec(Accuracy::kExact, Scalar::kF64));
  EXPECT_EQ(judged.vertex_triangle.size() + judged.edge_edge.size(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Frames, RealFramesTest,
                         ::testing::Combine(::testing::ValuesIn(kGolden),
                                            ::testing::Values(Backend::kCpu, Backend::kCuda)),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param).frames.name) +
                                  (std::get<1>(info.param) == Backend::kCpu ? "_cpu" : "_cuda");
                         });

}  // namespace
}  // namespace collided::test
