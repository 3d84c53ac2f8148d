// How 'collidectl tradeoff' reports its results.

#include "client/measure/tradeoff/report.hpp"

#include <gtest/gtest.h>

#include "client/measure/tradeoff/result_json.hpp"

namespace collided::cli {
namespace {

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
  guarded.bytes = 7200;
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

TEST(Tradeoff, TheJsonHasTheSettingAndEveryRun) {
  const Json json = tradeoff_json(sample());
  EXPECT_EQ(json["format"], "collided tradeoff 1");
  EXPECT_EQ(json["name"], "funnel");
  EXPECT_EQ(json["device"], "CPU, 1 thread");
  EXPECT_EQ(json["triangles"], 12345);
  EXPECT_EQ(json["truths"][0], (Json{{"position_format", "f32"},
                                     {"source", "exact"},
                                     {"vertex_triangle", 1193},
                                     {"edge_edge", 40},
                                     {"bounded_times", 7}}));
  ASSERT_EQ(json["runs"].size(), 2u);
  EXPECT_EQ(json["runs"][0]["delta"], nullptr);
  EXPECT_EQ(json["runs"][0]["contacts"]["sum"],
            (Json{{"reported", 1240}, {"right", 1230}, {"missed", 3}, {"false", 10}, {"late", 2}}));
  EXPECT_EQ(json["runs"][0]["contacts"]["toi_gap"], (Json{{"median", 1e-9}, {"p99", 0.1}, {"worst", 1.0 / 3}}));
  EXPECT_EQ(json["runs"][1]["level"], "guarded");
  EXPECT_EQ(json["runs"][1]["delta"], 1e-3);
  EXPECT_EQ(json["runs"][1]["bytes_in"], 7200);
  EXPECT_EQ(json["runs"][1]["contacts"]["toi_gap"], nullptr);
  EXPECT_EQ(json["runs"][1]["median_ms"]["narrow"], 0.25);
  EXPECT_EQ(json["runs"][1]["counts"]["exact_decisions"], 3);
}

TEST(Tradeoff, TheTableHasARowForEachRun) {
  const std::string table = tradeoff_markdown(sample());
  EXPECT_NE(table.find("| f32 | fast | - | 1,240 (1,200 + 40) | 1,230 (1,190 + 40) | 3 (3 + 0) | 10 (10 + 0) | 2 (2 + "
                       "0) | 2.0e-07 | 1.0e-09 | 1.0e-01 | 3.3e-01 |"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("| f32 | guarded | 1e-3 | 0.25 | 0.50 | 2 | 1.00 | 4 | 1.00 | 7,200 | 1 | 2 | 4 | 5 | 6 | 3 |"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("f32: the level `EXACT` on the same positions; 1,193 vertex-triangle and 40 edge-edge"),
            std::string::npos);
}

TEST(Tradeoff, DeltasAreShort) {
  EXPECT_EQ(delta_text(0), "auto");
  EXPECT_EQ(delta_text(1e-3), "1e-3");
  EXPECT_EQ(delta_text(2.5e-7), "2.5e-7");
  EXPECT_EQ(delta_text(1e-12), "1e-12");
  EXPECT_EQ(delta_text(0.1), "0.1");
  EXPECT_EQ(delta_text(100), "100");
}

}  // namespace
}  // namespace collided::cli
