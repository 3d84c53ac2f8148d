// The judge of 'collidectl tradeoff' on hand-made lists, truths read from files, results written and read back.

#include "client/measure/tradeoff/judge.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "client/cli/output/output.hpp"
#include "client/measure/tradeoff/report.hpp"

namespace collided::cli {
namespace {

class Tradeoffs : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string(test->name()) + std::to_string(getpid()));
    std::filesystem::create_directory(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path put(const std::string& name, const std::string& text) {
    write_text(folder_ / name, text);
    return folder_ / name;
  }
  std::string error_of(const std::string& vf, const std::string& ee = "a0,a1,b0,b1,collides,toi\n") {
    put("vf.csv", vf);
    put("ee.csv", ee);
    try {
      read_truth(folder_);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  }
  std::filesystem::path folder_;
};

void add(client::Contacts& contacts, std::array<uint32_t, 2> elements, std::array<uint32_t, 4> stencil, double toi) {
  ++contacts.count;
  contacts.elements.push_back(elements);
  contacts.stencils.push_back(stencil);
  contacts.toi.push_back(toi);
}

/// Vertices 10, 11, ... against triangle 5, one for each time.
client::FrameOutput vertex_triangle(std::initializer_list<double> times) {
  client::FrameOutput output;
  uint32_t vertex = 10;
  for (const double toi : times) add(output.vertex_triangle, {vertex++, 5}, {0, 1, 2, 3}, toi);
  return output;
}

/// The truth where all times are exact.
Truth exactly(const client::FrameOutput& output) { return exact_truth(output, output); }

TEST(Judge, RightContactsHaveTheirGaps) {
  const Truth truth = exactly(vertex_triangle({0.5, 0.25, 1, 0}));
  const Score score = judge(truth, vertex_triangle({0.5, 0.125, 0.5, 0}));
  EXPECT_EQ(score.vertex_triangle, (KindScore{.reported = 4, .right = 4, .missed = 0, .wrong = 0, .late = 0}));
  EXPECT_EQ(score.edge_edge, KindScore{});
  EXPECT_EQ(score.gap, (Gap{.median = 0, .p99 = 0.5, .worst = 0.5}));
  EXPECT_EQ(score.latest, 0);
}

TEST(Judge, MissedAndFalseContactsAreCountedByKind) {
  client::FrameOutput truth_output = vertex_triangle({0.1, 0.2, 0.3}), output;
  add(truth_output.edge_edge, {1, 2}, {1, 2, 3, 4}, 0.5);
  add(output.vertex_triangle, {11, 5}, {}, 0.2);
  add(output.vertex_triangle, {11, 6}, {}, 0.2);  // another triangle: not true
  add(output.edge_edge, {1, 2}, {1, 2, 3, 4}, 0.5);
  add(output.edge_edge, {1, 3}, {1, 2, 3, 5}, 0.5);
  const Score score = judge(exactly(truth_output), output);
  EXPECT_EQ(score.vertex_triangle, (KindScore{.reported = 2, .right = 1, .missed = 2, .wrong = 1, .late = 0}));
  EXPECT_EQ(score.edge_edge, (KindScore{.reported = 2, .right = 1, .missed = 0, .wrong = 1, .late = 0}));
  EXPECT_EQ(sum(score), (KindScore{.reported = 4, .right = 2, .missed = 2, .wrong = 2, .late = 0}));
}

TEST(Judge, APairReportedTwiceIsRightOnce) {
  client::FrameOutput output = vertex_triangle({0.5});
  add(output.vertex_triangle, {10, 5}, {}, 0.5);
  const Score score = judge(exactly(vertex_triangle({0.5})), output);
  EXPECT_EQ(score.vertex_triangle, (KindScore{.reported = 2, .right = 1, .missed = 0, .wrong = 1, .late = 0}));
}

TEST(Judge, NothingReportedHasNoGap) {
  const Score score = judge(exactly(vertex_triangle({0.5})), {});
  EXPECT_EQ(sum(score).missed, 1u);
  EXPECT_FALSE(score.gap);
  EXPECT_EQ(judge({}, {}), Score{});
}

TEST(Judge, ExactTimesMayBeEarlyByTheirBracketAndNoMore) {
  const double tiny = 0x1p-50 + 0x1p-59, above_half = std::nextafter(0.5, 1), above_fifth = std::nextafter(0.2, 1);
  const Truth truth = exactly(vertex_triangle({0x1p-50, 0.5, 0.2}));
  EXPECT_EQ(sum(judge(truth, vertex_triangle({0x1p-50 + 0x1p-60, above_half, above_fifth}))).late, 0u);
  const Score late = judge(truth, vertex_triangle({tiny, std::nextafter(above_half, 1), 0.2}));
  EXPECT_EQ(late.vertex_triangle.late, 2u);
  EXPECT_EQ(late.latest, 0x1p-52);
  EXPECT_LT(late.gap->median, 0.1);
}

TEST(Judge, TimesOfAWideDeltaAreExactUnlessTheyAreZero) {
  const Truth truth = exact_truth(vertex_triangle({0.5, 0.5}), vertex_triangle({0, 0.625}));
  EXPECT_EQ(truth.bounded, 1u);
  EXPECT_EQ(truth.vertex_triangle[0].toi, 0.5);
  EXPECT_EQ(truth.vertex_triangle[1].toi, 0.625);
  EXPECT_EQ(sum(judge(truth, vertex_triangle({0.5 + 0.9e-9, 0.625}))).late, 0u);
  EXPECT_EQ(sum(judge(truth, vertex_triangle({0.5 + 1.1e-9, 0.625 + 1e-12}))).late, 2u);
}

TEST(Judge, ContradictionsAreNoTruth) {
  EXPECT_THROW(exact_truth(vertex_triangle({0.5}), vertex_triangle({0.5, 0.5})), std::runtime_error);
}

TEST(Judge, OneInAHundredIsBeyondTheP99) {
  client::FrameOutput truth, output;
  for (uint32_t i = 0; i < 1000; ++i) {
    add(truth.edge_edge, {i, 5000}, {i, 2000, 3000, 4000}, 0.5);
    add(output.edge_edge, {i, 5000}, {i, 2000, 3000, 4000}, 0.5 - i / 2000.0);
  }
  const Gap gap = *judge(exactly(truth), output).gap;
  EXPECT_EQ(gap.median, 0.5 - (0.5 - 499 / 2000.0));
  EXPECT_EQ(gap.p99, 0.5 - (0.5 - 989 / 2000.0));
  EXPECT_EQ(gap.worst, 0.5 - (0.5 - 999 / 2000.0));
}

TEST(Judge, ContactsThatCannotBeJudgedAreRefused) {
  client::FrameOutput output = vertex_triangle({0.5});
  output.vertex_triangle.toi.clear();
  EXPECT_THROW(judge({}, output), std::runtime_error);
}

TEST_F(Tradeoffs, ATruthIsReadWithWhatItsLastDigitAllows) {
  put("vf.csv", "vertex,triangle,collides,toi\r\n7,3,1,0.25\r\n6,3,0,\r\n5,3,1,7.5e-06\n4,3,1,1\n");
  put("ee.csv", "a0,a1,b0,b1,collides,toi\n9,8,2,7,1,0.125\n");
  const Truth truth = read_truth(folder_);
  ASSERT_EQ(truth.vertex_triangle.size(), 3u);
  EXPECT_EQ(truth.vertex_triangle[0].pair, (PairKey{4, 3, 0, 0}));
  EXPECT_NEAR(truth.vertex_triangle[1].last_toi, 7.6e-6, 1e-20);
  EXPECT_NEAR(truth.vertex_triangle[2].last_toi, 0.26, 1e-15);
  EXPECT_EQ(truth.edge_edge[0].pair, (PairKey{2, 7, 8, 9}));

  client::FrameOutput output;
  add(output.vertex_triangle, {7, 3}, {}, 0.2599);
  add(output.edge_edge, {0, 1}, {2, 7, 8, 9}, 0.127);
  const Score score = judge(truth, output);
  EXPECT_EQ(score.vertex_triangle, (KindScore{.reported = 1, .right = 1, .missed = 2, .wrong = 0, .late = 0}));
  EXPECT_EQ(score.edge_edge, (KindScore{.reported = 1, .right = 1, .missed = 0, .wrong = 0, .late = 1}));
}

TEST_F(Tradeoffs, BadTruthsAreRefusedByLine) {
  const std::string head = "vertex,triangle,collides,toi\n";
  EXPECT_EQ(error_of(head + "1,2,1,0.5\n"), "");
  EXPECT_NE(error_of("").find("vf.csv: cannot be read"), std::string::npos);
  EXPECT_NE(error_of("v,t\n").find("vf.csv:1: the first line is not"), std::string::npos);
  EXPECT_NE(error_of(head + "1,2,1\n").find("vf.csv:2: has 3 cells; it needs 4"), std::string::npos);
  EXPECT_NE(error_of(head + "1,2,1,.5\n-1,2,1,.5\n").find("vf.csv:3: '-1' is no id"), std::string::npos);
  EXPECT_NE(error_of(head + "1,2,yes,0.5\n").find("collides is 'yes'"), std::string::npos);
  for (const char* toi : {"", "soon", "1.5", "-0.1", "nan", "0.5x", "1e"})
    EXPECT_NE(error_of(head + "1,2,1," + toi + "\n").find("must be in [0, 1]"), std::string::npos) << toi;
  EXPECT_NE(error_of(head, "a0,a1,b0,b1,collides,toi\n1,2,3,1,0.5\n").find("ee.csv:2"), std::string::npos);
}

Tradeoff sample() {
  Run fast{.format = "f32", .level = "fast"};
  fast.score.vertex_triangle = {.reported = 1200, .right = 1190, .missed = 3, .wrong = 10, .late = 2};
  fast.score.edge_edge = {.reported = 40, .right = 40, .missed = 0, .wrong = 0, .late = 0};
  fast.score.gap = Gap{1e-9, 0.1, 1.0 / 3};
  fast.score.latest = 2e-7;
  fast.times = {.narrow = 0.5, .stages = 2, .total = 4, .stage = {{"narrow_vt", 0.2}, {"narrow_ee", 0.3}}};
  Run guarded = fast;
  guarded.level = "guarded";
  guarded.delta = 1e-3;
  guarded.score.gap = std::nullopt;
  guarded.times.narrow = 0.25;
  guarded.work = {1, 2, 3, 4, 5, 6};
  return {.name = "funnel",
          .input = "scene funnel",
          .date = "2026-11-21",
          .commit = "abc",
          .version = "0.1.0",
          .backend = "cpu",
          .device = "CPU, 1 thread",
          .vertices = 10,
          .edges = 20,
          .triangles = 12345,
          .thickness = 0.1,
          .repeats = 3,
          .truths = {{"f32", "exact", 1193, 40, 7}},
          .runs = {fast, guarded}};
}

TEST_F(Tradeoffs, AResultIsReadBackAsItWas) {
  EXPECT_EQ(read_tradeoff(put("t.json", tradeoff_json(sample()).dump(2))), sample());
}

TEST_F(Tradeoffs, OtherFilesAreNoResults) {
  const auto error = [&](const Json& json) -> std::string {
    try {
      read_tradeoff(put("t.json", json.is_string() ? json.get<std::string>() : json.dump()));
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(error("{").find("t.json: is no result of 'collidectl tradeoff'"), std::string::npos);
  EXPECT_NE(error("[]").find("is no result"), std::string::npos);
  EXPECT_NE(error(Json{{"format", "other"}}).find("format"), std::string::npos);
  Json json = tradeoff_json(sample());
  json["runs"][1]["level"] = "perfect";
  EXPECT_NE(error(json).find("'perfect' is not known"), std::string::npos);
  json = tradeoff_json(sample());
  json["runs"][0].erase("median_ms");
  EXPECT_NE(error(json).find("median_ms"), std::string::npos);
  json = tradeoff_json(sample());
  json["runs"] = Json::array();
  EXPECT_NE(error(json).find("no runs"), std::string::npos);
  json["triangles"] = "many";
  EXPECT_NE(error(json).find("is no result"), std::string::npos);
  EXPECT_THROW(read_tradeoff(folder_ / "none.json"), std::runtime_error);
}

TEST(Report, TheTableHasARowForEachRun) {
  const std::string table = tradeoff_markdown(sample());
  EXPECT_NE(table.find("| f32 | fast | - | 1,240 (1,200 + 40) | 1,230 (1,190 + 40) | 3 (3 + 0) | 10 (10 + 0) | 2 (2 + "
                       "0) | 2.0e-07 | 1.0e-09 | 1.0e-01 | 3.3e-01 |"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("| f32 | guarded | 1e-3 | 0.25 | 0.50 | 2 | 1.00 | 4 | 1.00 | 1 | 2 | 4 | 5 | 6 | 3 |"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("f32: the level `EXACT` on the same positions; 1,193 vertex-triangle and 40 edge-edge"),
            std::string::npos);
}

TEST(Report, DeltasAreShort) {
  EXPECT_EQ(delta_text(0), "auto");
  EXPECT_EQ(delta_text(1e-3), "1e-3");
  EXPECT_EQ(delta_text(2.5e-7), "2.5e-7");
  EXPECT_EQ(delta_text(1e-12), "1e-12");
  EXPECT_EQ(delta_text(0.1), "0.1");
  EXPECT_EQ(delta_text(100), "100");
}

}  // namespace
}  // namespace collided::cli
