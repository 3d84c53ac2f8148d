// Queries four at a time, as CPU cores do them, against one after the other: the same bits.

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "gpu/exec/cpu/resumable.hpp"
#include "gpu/narrow/cpu/approach.hpp"
#include "gpu/narrow/cpu/screen.hpp"
#include "tests/support/families/query_families.hpp"
#include "tests/support/families/query_families_shapes.hpp"

namespace collided::test {
namespace {

constexpr QueryKind kind_of(const VertexTriangle&) { return QueryKind::kVertexTriangle; }
constexpr QueryKind kind_of(const EdgeEdge&) { return QueryKind::kEdgeEdge; }

/// Hard queries of all families, neighbours of different ones, and features that coincide.
std::vector<Query> hard_queries(QueryKind kind, Scalar scalar) {
  constexpr uint64_t kEach = 200;
  std::vector<Query> all;
  for (const auto* families : {&fuzz_families(), &extreme_families()})
    for (const QueryFamily& family : *families)
      if (scalar == Scalar::kF64 || !family.f64_only)
        for (Query& query : queries_of({&family, kind, scalar, 77}, kEach)) all.push_back(query);
  for (int k = 0; k < 40; ++k) all.push_back(Query{kind, {}});
  Random random(5);
  for (size_t i = all.size() - 1; i > 0; --i)
    std::swap(all[i], all[static_cast<size_t>(random.integer(0, static_cast<int>(i)))]);
  return all;
}

struct FourSettings {
  double thickness = 0, delta = 0, encoding = 0;
  bool turns = false;  ///< meshes of ten vertices each, some of which turn
};

/// Queries as the narrow phase has them: each of vertices of its own.
template <class Real, class Kind>
class QueryScene {
 public:
  QueryScene() {
    const Scalar scalar = sizeof(Real) == 4 ? Scalar::kF32 : Scalar::kF64;
    for (const Query& query : hard_queries(kind_of(Kind{}), scalar)) add(query);
    for (uint32_t first = 0; first < start_.size(); first += 10) {
      first_vertex_.push_back(first);
      deviations_.push_back(first % 3 == 0 ? 0 : 1e-3 / (1 + first % 7));
    }
    deviations_.push_back(1e-3);
  }

  uint64_t size() const { return keys_.size(); }
  ScreenCcd<Real, Kind> screen(const FourSettings& settings, std::vector<uint64_t>& found, uint64_t& count) const {
    found.resize(size());
    return {queries(settings), {{found.data(), found.size()}, &count}};
  }
  ApproachCcd<Real, Kind> approach(const FourSettings& settings, std::vector<ResumableQuery>& found,
                                   uint64_t& count) const {
    found.resize(size());
    return {queries(settings), {{found.data(), found.size()}, &count}};
  }

 private:
  void add(const Query& query) {
    const auto i = static_cast<uint32_t>(keys_.size());
    keys_.push_back(kind_of(Kind{}) == QueryKind::kVertexTriangle ? pack_ids(4 * i, i) : pack_ids(2 * i, 2 * i + 1));
    triangles_.push_back({4 * i + 1, 4 * i + 2, 4 * i + 3});
    edges_.insert(edges_.end(), {{4 * i, 4 * i + 1}, {4 * i + 2, 4 * i + 3}});
    for (size_t k = 0; k < 8; ++k) {
      const Vec3d& p = query.p[k];
      (k < 4 ? start_ : end_).push_back({static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2])});
    }
  }
  template <class T>
  static Span<const T> span(const std::vector<T>& values) {
    return {values.data(), values.size()};
  }
  VertexTriangle kind(const VertexTriangle&) const { return {span(triangles_)}; }
  EdgeEdge kind(const EdgeEdge&) const { return {span(edges_)}; }
  CcdQueries<Real, Kind, uint64_t> queries(const FourSettings& settings) const {
    Deviations deviations;
    if (settings.turns)
      deviations = {first_vertex_.data(), deviations_.data(), static_cast<uint32_t>(first_vertex_.size())};
    return {start_.data(),  end_.data(),  settings.thickness, {settings.encoding, deviations},
            settings.delta, kind(Kind{}), span(keys_)};
  }

  std::vector<Vec3<Real>> start_, end_;
  std::vector<uint64_t> keys_;
  std::vector<Vec3<uint32_t>> triangles_;
  std::vector<EdgePair> edges_;
  std::vector<uint32_t> first_vertex_;
  std::vector<double> deviations_;
};

/// In ranges of any length.
template <class F>
void run_in_ranges(const F& f, uint64_t count) {
  constexpr uint64_t kMost = InRanges<F>::kItems, kLengths[] = {1, 2, 3, 4, 5, 7, kMost - 1, kMost};
  uint64_t first = 0;
  for (size_t k = 0; first < count; ++k) {
    const uint64_t end = std::min(count, first + kLengths[k % std::size(kLengths)]);
    InRanges<F>::run(f, first, end);
    first = end;
  }
}

using ProgressBits = std::tuple<uint64_t, uint32_t, uint32_t, uint32_t, uint32_t, uint32_t, uint32_t>;

/// In the order of the keys: which query is done first does not matter.
std::vector<ProgressBits> sorted_bits(const std::vector<ResumableQuery>& queries, uint64_t count) {
  const auto bits = [](float x) { return detail::bit_copy<uint32_t>(x); };
  std::vector<ProgressBits> out;
  for (uint64_t i = 0; i < count; ++i) {
    const auto& [t, pace] = queries[i].progress;
    out.emplace_back(queries[i].key, bits(t), bits(pace.share), bits(pace.bend), bits(pace.limit), bits(pace.growth),
                     bits(pace.shrink));
  }
  std::sort(out.begin(), out.end());
  return out;
}

template <class Case>
class FourQueries : public testing::Test {
 protected:
  using Scene = QueryScene<typename Case::first_type, typename Case::second_type>;

  static std::vector<FourSettings> settings() {
    return {{},
            {.thickness = 1e-3},
            {.thickness = 0.3},
            {.delta = 1e-3},
            {.encoding = 1e-5},
            {.thickness = 1e-12, .encoding = 1e-3},
            {.turns = true},
            {.thickness = 1e-3, .delta = 1e-6, .turns = true}};
  }
  const Scene scene_;
};
using FourCases = testing::Types<std::pair<float, VertexTriangle>, std::pair<float, EdgeEdge>,
                                 std::pair<double, VertexTriangle>, std::pair<double, EdgeEdge>>;
TYPED_TEST_SUITE(FourQueries, FourCases);

TYPED_TEST(FourQueries, AreScreenedAsOneAfterTheOther) {
  for (const FourSettings& settings : this->settings()) {
    std::vector<uint64_t> found, expected;
    uint64_t found_count = 0, expected_count = 0;
    const auto one = this->scene_.screen(settings, expected, expected_count);
    for (uint64_t i = 0; i < this->scene_.size(); ++i) one(i);
    run_in_ranges(this->scene_.screen(settings, found, found_count), this->scene_.size());
    ASSERT_EQ(found_count, expected_count);
    EXPECT_EQ(found, expected);
    EXPECT_GT(found_count, this->scene_.size() / 10);
    EXPECT_LT(found_count, this->scene_.size());
  }
}

TYPED_TEST(FourQueries, ApproachAsOneAfterTheOther) {
  for (const FourSettings& settings : this->settings()) {
    std::vector<ResumableQuery> found, expected;
    uint64_t found_count = 0, expected_count = 0;
    const auto one = this->scene_.approach(settings, expected, expected_count);
    for (uint64_t i = 0; i < this->scene_.size(); ++i) do_resumable(one, i);
    run_in_ranges(this->scene_.approach(settings, found, found_count), this->scene_.size());
    ASSERT_EQ(found_count, expected_count);
    EXPECT_EQ(sorted_bits(found, found_count), sorted_bits(expected, expected_count));
    EXPECT_GT(found_count, this->scene_.size() / 10);
    EXPECT_LT(found_count, this->scene_.size());
  }
}

TYPED_TEST(FourQueries, CountPastTheRoomOfTheirList) {
  std::vector<uint64_t> found;
  uint64_t all = 0, count = 0;
  run_in_ranges(this->scene_.screen({}, found, all), this->scene_.size());
  auto screen = this->scene_.screen({}, found, count);
  const std::vector<uint64_t> expected(found.begin(), found.begin() + 5);
  std::fill(found.begin(), found.end(), ~uint64_t{0});
  screen.survivors.items.count = 5;
  run_in_ranges(screen, this->scene_.size());
  EXPECT_EQ(count, all);
  EXPECT_EQ(std::vector<uint64_t>(found.begin(), found.begin() + 5), expected);
  EXPECT_EQ(found[5], ~uint64_t{0});
}

}  // namespace
}  // namespace collided::test
