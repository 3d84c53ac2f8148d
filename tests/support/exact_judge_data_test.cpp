// The judge against labels that others made.

#include <gtest/gtest.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdio>
#include <ctime>

#include "tests/support/brute_force.hpp"
#include "tests/support/labelled.hpp"

namespace collided::test {
namespace {

// Of this thread alone: the machine may be busy.
int64_t cpu_nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

// Judges all queries and says how many disagree with their labels.
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
    data_ = data_folder();
    if (!data_) GTEST_SKIP() << "the data folder is not here; set COLLIDED_DATA";
  }
  std::optional<std::filesystem::path> data_;
};

TEST_F(ExactJudgeData, AgreesWithTheHandMadeQueries) {
  size_t queries = 0, disagree = 0;
  for (const std::string& set : query_sets(*data_)) {
    const std::vector<LabelledQuery> labelled = read_query_set(*data_, set);
    queries += labelled.size();
    disagree += disagreements(set, labelled);
  }
  std::printf("%zu queries: %zu disagree\n", queries, disagree);
  EXPECT_EQ(queries, 3824u);
  EXPECT_EQ(disagree, 0u);
}

TEST_F(ExactJudgeData, AgreesWithTheFunnelFrames) {
  const std::vector<LabelledQuery> queries = read_frame_queries(*data_, kFunnelFrames);
  EXPECT_EQ(queries.size(), 355u);
  EXPECT_EQ(disagreements(kFunnelFrames.name, queries), 0u);
}

TEST_F(ExactJudgeData, AgreesWithTheBallFrames) {
  const std::vector<LabelledQuery> queries = read_frame_queries(*data_, kBallFrames);
  EXPECT_EQ(queries.size(), 113859u);
  EXPECT_EQ(disagreements(kBallFrames.name, queries), 0u);
}

// The truth lists what collides. What it does not list must not: then there are as many hits among all pairs whose
// boxes meet as there are in the list.
size_t hits_among(const Case& c, QueryKind kind, const std::vector<PairKey>& pairs) {
  const Features features = features_of(c);
  std::atomic<size_t> hits = 0;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, pairs.size()), [&](const auto& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) {
      const auto first = static_cast<uint32_t>(pairs[i] >> 32), second = static_cast<uint32_t>(pairs[i]);
      std::array<uint32_t, 4> points;
      if (kind == QueryKind::kVertexTriangle) {
        const auto& corners = features.triangles[second];
        points = {first, corners[0], corners[1], corners[2]};
      } else {
        const auto &e = features.edges[first], &f = features.edges[second];
        points = {e[0], e[1], f[0], f[1]};
      }
      Query query{kind, {}};
      for (size_t k = 0; k < 8; ++k) query.p[k] = (k < 4 ? c.start : c.end)[0][points[k % 4]];
      if (judge_ccd(query).hit) ++hits;
    }
  });
  return hits;
}

size_t hits_listed(const std::filesystem::path& data, const RealFrames& frames, QueryKind kind) {
  size_t hits = 0;
  for (const TruthRow& row : read_truth(data, frames, kind)) hits += row.hit;
  return hits;
}

TEST_F(ExactJudgeData, NothingUnlistedCollides) {
  for (const RealFrames& frames : {kFunnelFrames, kBallFrames}) {
    const Case c = load(*data_, frames);
    const ExpectedPairs pairs = brute_force(c, Mode::kCcd, Scalar::kF64, 0);
    const size_t vertex_triangle = hits_among(c, QueryKind::kVertexTriangle, pairs.vertex_triangle.must);
    const size_t edge_edge = hits_among(c, QueryKind::kEdgeEdge, pairs.edge_edge.must);
    std::printf("%s: %zu of %zu vertex-triangle and %zu of %zu edge-edge candidates collide\n", frames.name,
                vertex_triangle, pairs.vertex_triangle.must.size(), edge_edge, pairs.edge_edge.must.size());
    EXPECT_EQ(vertex_triangle, hits_listed(*data_, frames, QueryKind::kVertexTriangle));
    EXPECT_EQ(edge_edge, hits_listed(*data_, frames, QueryKind::kEdgeEdge));
  }
}

}  // namespace
}  // namespace collided::test
