// The judge against labels by others, and against the truth of our own frames.

#include <gtest/gtest.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdio>
#include <ctime>

#include "tests/support/case_queries.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/frames/frame_truth.hpp"

namespace collided::test {
namespace {

// CPU time of this thread: the machine may be busy.
int64_t cpu_nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

// Judges all queries and returns how many disagree with their labels.
size_t disagreements(const std::string& name, const std::vector<LabelledQuery>& queries) {
  std::atomic<size_t> disagree = 0, hits = 0;
  std::atomic<int64_t> nanoseconds = 0, slowest = 0;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, queries.size()), [&](const auto& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) {
      const int64_t start = cpu_nanoseconds();
      const ExactImpact impact = judge_ccd(queries[i].query);
      const int64_t time = cpu_nanoseconds() - start;
      nanoseconds += time;
      for (int64_t seen = slowest; time > seen && !slowest.compare_exchange_weak(seen, time);) continue;
      if (impact.hit) ++hits;
      if (!agrees(impact, queries[i])) ++disagree;
    }
  });
  std::printf("%s: %zu queries, %zu hits: %zu disagree; %.1f us a query, slowest %.1f us\n", name.c_str(),
              queries.size(), hits.load(), disagree.load(), 1e-3 * double(nanoseconds) / double(queries.size()),
              1e-3 * double(slowest));
  return disagree;
}

class ExactJudgeData : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!data_folder()) GTEST_SKIP() << kNoDataFolder;
  }
};

TEST_F(ExactJudgeData, AgreesWithTheHandMadeQueries) {
  const std::filesystem::path data = *data_folder();
  size_t queries = 0, disagree = 0;
  for (const std::string& set : query_sets(data)) {
    const std::vector<LabelledQuery> labelled = read_query_set(data, set);
    queries += labelled.size();
    disagree += disagreements(set, labelled);
  }
  std::printf("%zu queries: %zu disagree\n", queries, disagree);
  EXPECT_EQ(queries, 3824u);
  EXPECT_EQ(disagree, 0u);
}

TEST_F(ExactJudgeData, AgreesWithTheFunnelFrames) {
  const std::vector<LabelledQuery> queries = read_frame_queries(kFunnelFrames);
  EXPECT_EQ(queries.size(), 355u);
  EXPECT_EQ(disagreements(kFunnelFrames.name, queries), 0u);
}

TEST_F(ExactJudgeData, AgreesWithTheBallFrames) {
  const std::vector<LabelledQuery> queries = read_frame_queries(kBallFrames);
  EXPECT_EQ(queries.size(), 113859u);
  EXPECT_EQ(disagreements(kBallFrames.name, queries), 0u);
}

// The truth lists the pairs that collide, and no others may: there are as many hits among all pairs whose boxes overlap
// as in the list.
size_t hits_among(const CaseQueries& queries, QueryKind kind, const std::vector<PairKey>& pairs) {
  std::atomic<size_t> hits = 0;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, pairs.size()), [&](const auto& range) {
    for (size_t i = range.begin(); i < range.end(); ++i)
      if (judge_ccd(queries.of_pair(kind, pairs[i])).hit) ++hits;
  });
  return hits;
}

size_t hits_listed(const RealFrames& frames, QueryKind kind) {
  size_t hits = 0;
  for (const TruthRow& row : read_truth(frames, kind)) hits += row.hit;
  return hits;
}

void expect_nothing_unlisted_collides(const RealFrames& frames) {
  const Case c = load(frames);
  const CaseQueries queries(c);
  const ExpectedPairs pairs = brute_force(c, Mode::kCcd, Scalar::kF64, 0);
  const size_t vertex_triangle = hits_among(queries, QueryKind::kVertexTriangle, pairs.vertex_triangle.must);
  const size_t edge_edge = hits_among(queries, QueryKind::kEdgeEdge, pairs.edge_edge.must);
  std::printf("%s: %zu of %zu vertex-triangle and %zu of %zu edge-edge candidates collide\n", frames.name,
              vertex_triangle, pairs.vertex_triangle.must.size(), edge_edge, pairs.edge_edge.must.size());
  EXPECT_EQ(vertex_triangle, hits_listed(frames, QueryKind::kVertexTriangle));
  EXPECT_EQ(edge_edge, hits_listed(frames, QueryKind::kEdgeEdge));
}

TEST_F(ExactJudgeData, NothingUnlistedCollides) {
  for (const RealFrames& frames : {kFunnelFrames, kBallFrames}) expect_nothing_unlisted_collides(frames);
}

// Regenerated frames need a regenerated truth.
TEST(OwnFrames, TruthIsWhatTheJudgeSays) {
  const std::vector<LabelledQuery> queries = read_frame_queries(kDrapeFrames);
  EXPECT_GT(queries.size(), 1000u);
  EXPECT_EQ(disagreements(kDrapeFrames.name, queries), 0u);
  expect_nothing_unlisted_collides(kDrapeFrames);
}

}  // namespace
}  // namespace collided::test
