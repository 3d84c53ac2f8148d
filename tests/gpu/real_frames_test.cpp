// Real simulations: the number of candidates is known, and so is every pair that collides.

#include <algorithm>
#include <cstdio>
#include <map>

#include "tests/gpu/backend.hpp"
#include "tests/support/brute_force.hpp"
#include "tests/support/labelled.hpp"

namespace collided::test {
namespace {

struct Golden {
  RealFrames frames;
  size_t vertex_triangle, edge_edge;  ///< candidates: closed swept boxes in double
};

void PrintTo(const Golden& g, std::ostream* out) { *out << g.frames.name; }

const Golden kGolden[] = {{kFunnelFrames, 7319, 33770}, {kBallFrames, 1655541, 5197332}};

using Truth = std::map<PairKey, double>;  ///< time of impact of every pair that collides

Truth truth_vt(const std::filesystem::path& data, const RealFrames& frames) {
  Truth truth;
  for (const TruthRow& row : read_truth(data, frames, QueryKind::kVertexTriangle))
    if (row.hit) truth[key_of(row.ids[0], row.ids[1])] = std::stod(row.toi);
  return truth;
}

Truth truth_ee(const std::filesystem::path& data, const RealFrames& frames, const Topology& topology) {
  const auto id = [&](uint32_t a, uint32_t b) {
    const std::array<uint32_t, 2> edge{std::min(a, b), std::max(a, b)};
    return static_cast<uint32_t>(std::lower_bound(topology.edges.begin(), topology.edges.end(), edge) -
                                 topology.edges.begin());
  };
  Truth truth;
  for (const TruthRow& row : read_truth(data, frames, QueryKind::kEdgeEdge)) {
    const uint32_t e = id(row.ids[0], row.ids[1]), f = id(row.ids[2], row.ids[3]);
    if (row.hit) truth[key_of(std::min(e, f), std::max(e, f))] = std::stod(row.toi);
  }
  return truth;
}

struct Score {
  size_t expected = 0, found = 0, right = 0, late = 0;
  double recall() const { return expected ? double(right) / double(expected) : 1; }
  double precision() const { return found ? double(right) / double(found) : 1; }
};

Score score_of(const ContactSet& contacts, const Truth& truth) {
  Score score{truth.size(), contacts.size(), 0, 0};
  for (size_t i = 0; i < contacts.size(); ++i) {
    const auto at = truth.find(key_of(contacts.elements[i][0], contacts.elements[i][1]));
    if (at == truth.end()) continue;
    ++score.right;
    if (contacts.toi[i] > at->second + 1e-6) ++score.late;
  }
  return score;
}

class RealFramesTest : public ::testing::TestWithParam<std::tuple<Golden, Backend>> {
 protected:
  void SetUp() override {
    if (backend() == Backend::kCuda && !cuda_available()) GTEST_SKIP() << "no CUDA device can be used";
    data_ = data_folder();
    if (!data_) GTEST_SKIP() << "the data folder is not here; set COLLIDED_DATA";
    case_ = load(*data_, golden().frames);
  }
  const Golden& golden() const { return std::get<0>(GetParam()); }
  Backend backend() const { return std::get<1>(GetParam()); }
  SceneSpec spec(Accuracy accuracy, Scalar scalar) const {
    SceneSpec s = settings(Mode::kCcd, accuracy, scalar);
    s.backend = backend();
    return s;
  }

  void print(const char* what, const Score& s) {
    std::printf("%s %s: recall %.6f (%zu of %zu), precision %.6f (%zu reported), late %zu\n", golden().frames.name,
                what, s.recall(), s.right, s.expected, s.precision(), s.found, s.late);
    RecordProperty(std::string(what) + "_recall", std::to_string(s.recall()));
    RecordProperty(std::string(what) + "_precision", std::to_string(s.precision()));
    RecordProperty(std::string(what) + "_late", std::to_string(s.late));
  }

  std::optional<std::filesystem::path> data_;
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
  const auto detector = Detector::create(spec_for(case_, spec(Accuracy::kFast, Scalar::kF64)));
  const FrameResult r = detector->detect(Frame(case_, Mode::kCcd, Scalar::kF64).input());
  const Score vt = score_of(r.vertex_triangle, truth_vt(*data_, golden().frames));
  const Score ee = score_of(r.edge_edge, truth_ee(*data_, golden().frames, detector->topology()));
  print("vertex_triangle", vt);
  print("edge_edge", ee);
  for (const Score& score : {vt, ee}) {
    EXPECT_GE(score.recall(), 0.95);
    EXPECT_GE(score.precision(), 0.5);
  }
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
