// The judge of 'collidectl tradeoff' on hand-made lists, and truths read from files.

#include "client/measure/tradeoff/judge.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "client/app/output/output.hpp"
#include "client/measure/tradeoff/judge.hpp"
#include "client/measure/tradeoff/report.hpp"

namespace collided::cli {
namespace {

class TruthFiles : public testing::Test {
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

TEST_F(TruthFiles, ATruthIsReadWithWhatItsLastDigitAllows) {
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

TEST_F(TruthFiles, BadTruthsAreRefusedByLine) {
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

}  // namespace
}  // namespace collided::cli
